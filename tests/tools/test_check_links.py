"""The check of links finds files and anchors that do not exist, and files from elsewhere."""

from support.scripts import load_script

links = load_script("tools/check_links.py")


def test_broken_links_are_found(tmp_path):
    (tmp_path / "part").mkdir()
    (tmp_path / "part" / "index.html").write_text(
        '<h1 id="one">One</h1><a href="../#top">up</a><a href="#one">here</a>'
    )
    (tmp_path / "index.html").write_text(
        '<a id="top" href="part/#one">good</a><a href="part/#two">anchor</a><a href="gone/">no</a>'
        '<a href="https://example.org/">elsewhere</a><script src="https://example.org/a.js"></script>'
        '<img src="no%20picture.png"><a href="mailto:a@example.org">mail</a>'
    )
    assert links.broken_links(tmp_path) == [
        "index.html: loads https://example.org/a.js",
        "index.html: part/#two: no such anchor",
        "index.html: gone/: no such file",
        "index.html: no%20picture.png: no such file",
    ]
