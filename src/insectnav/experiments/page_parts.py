"""What pages of results are made of: text from anywhere made safe, tables for a phone, and what they may load."""

import html
from collections.abc import Iterable, Sequence

# Nothing is loaded from anywhere, and nothing runs, whatever a file of results may have smuggled in.
POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"


def safe_text(value: object) -> str:
    """Text from anywhere, safe in HTML and in its attributes: escaped, and without what cannot be seen."""
    shown = "".join(letter if letter.isprintable() else "\ufffd" for letter in " ".join(str(value).split()))
    return html.escape(shown)


def whole_page(title: str, style: str, head: str, main: str) -> str:
    """A page of HTML that loads nothing; head and main part are HTML already."""
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{safe_text(POLICY)}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>insectnav: {safe_text(title)}</title>
<link rel="icon" href="data:,">
<style>{style}</style>
</head>
<body>
<header>
{head}
</header>
<main>
{main}
</main>
</body>
</html>
"""


def page_table(kind: str, caption: str, columns: Sequence[str], rows: str) -> str:
    """A table of HTML; columns and rows, of `page_row`, are HTML already."""
    head = "".join(f'<th scope="col">{column}</th>' for column in columns)
    return f"""<table class="{kind}">
<caption>{safe_text(caption)}</caption>
<thead><tr>{head}</tr></thead>
<tbody>
{rows}
</tbody>
</table>"""


def page_row(name: str, cells: Iterable[tuple[str, str]]) -> str:
    """A row of HTML whose cells know their column, which a narrow page shows beside them; all is HTML already."""
    data = "".join(f'<td data-column="{column}"><div>{content}</div></td>' for column, content in cells)
    return f'<tr><th scope="row">{name}</th>{data}</tr>'
