"""Places in documents that scripts write."""


def write_between(page, name, text):
    """Replaces what stands in a document between <!-- NAME --> and <!-- NAME: end -->; a sentence as SystemExit where these are not there once each."""
    begin, end = f"<!-- {name} -->\n", f"<!-- {name}: end -->"
    told = page.read_text()
    if told.count(begin) != 1 or told.count(end) != 1:
        raise SystemExit(f"{page} lacks the lines {begin.strip()} and {end}, between which this is written; put them back")
    before, rest = told.split(begin)
    page.write_text(f"{before}{begin}{text}{end}{rest.split(end)[1]}")
