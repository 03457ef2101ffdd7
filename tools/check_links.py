"""Check the links of a built site: every file and every anchor that a page names must exist.

Usage: python tools/check_links.py SITE

Links to other sites are not followed. A page must load nothing from elsewhere.
"""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """Links and anchors of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.loaded: list[str] = []
        """Files that the browser loads with the page."""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value for name, value in attrs if value}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        if "src" in given:
            self.loaded.append(given["src"])
        if "href" in given:
            outside = tag == "link" and given.get("rel") in ("canonical", "prev", "next")
            (self.loaded if tag == "link" and not outside else self.links).append(given["href"])


def broken_links(site: Path) -> list[str]:
    """Return a line for each link that leads nowhere, and for each file loaded from elsewhere."""
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}
    found = []
    for path, page in sorted(pages.items()):
        where = path.relative_to(site)
        found += [
            f"{where}: loads {link}"
            for link in page.loaded
            if urlsplit(link).scheme in ("http", "https") or link.startswith("//")
        ]
        for link in dict.fromkeys(page.links + page.loaded):
            if fault := _fault(link, path, site, pages):
                found.append(f"{where}: {link}: {fault}")
    return found


def _fault(link: str, path: Path, site: Path, pages: dict[Path, Page]) -> str:
    """What is wrong with a link of the page at `path`; empty if nothing is."""
    parts = urlsplit(link)
    if parts.scheme or parts.netloc:
        return ""
    start = site if parts.path.startswith("/") else path.parent
    target = (start / unquote(parts.path).lstrip("/")).resolve() if parts.path else path
    if target.is_dir():
        target /= "index.html"
    if not target.is_file():
        return "no such file"
    if parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors:
        return "no such anchor"
    return ""


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    site = Path(sys.argv[1]).resolve()
    pages = len(list(site.rglob("*.html")))
    if found := broken_links(site):
        sys.exit("\n".join(found))
    print(f"the links of {pages} pages lead to files and anchors that exist")


if __name__ == "__main__":
    main()
