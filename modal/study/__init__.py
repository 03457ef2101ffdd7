"""Study of a line: many cases over wind, ice and curves, measures, and one report with a verdict.

`study.py` computes, `verdict.py` writes sentences, `page.py` writes the HTML page.
"""
