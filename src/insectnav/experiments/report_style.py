"""How the report looks: dark text on white, on a desk, on a phone and on paper."""

# Verdicts are told apart by mark and word; their colours are ones that the colour-blind tell apart too (Okabe & Ito).
STYLE = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { max-width: 74rem; margin: 0 auto; padding: 1.5rem; background: #fff; color: #1a1a1a;
  font: 1rem/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; overflow-wrap: anywhere; }
h1 { font-size: 1.8rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.25rem; line-height: 1.3; margin: 0; }
a { color: #004f80; }
code { font: .9em/1.4 ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace; background: #f2f2f2;
  padding: .1em .3em; border-radius: 3px; }
header p { max-width: 52rem; }
code span { display: inline-block; max-width: calc(100% - 1em); }
section { margin-top: 2.5rem; padding-top: 1.5rem; border-top: 1px solid #c8c8c8; }
.lead { font-size: 1.15rem; }
.source { margin: .25rem 0 1rem; color: #4a4a4a; }
.note { margin: .5rem 0; padding: .4rem .8rem; border-left: 4px solid #b34a00; background: #fdf3ec; }
figure { margin: 1rem 0; }
img { display: block; max-width: min(100%, 60rem); height: auto; }
figcaption { margin-top: .5rem; max-width: 60rem; font-size: .92rem; color: #333; }
table { width: 100%; border-collapse: collapse; margin: 1.25rem 0; font-size: .92rem; }
caption { text-align: left; font-weight: 600; padding-bottom: .3rem; }
th, td { text-align: left; vertical-align: top; padding: .4rem .8rem .4rem 0; border-bottom: 1px solid #dcdcdc; }
thead th { border-bottom: 2px solid #6b6b6b; white-space: nowrap; }
tbody th { font-weight: 500; }
.summary th { white-space: nowrap; }
td p { margin: .2rem 0 0; }
.comparison { table-layout: fixed; }
.comparison th:first-child { width: 19%; }
.comparison th:nth-child(2), .comparison th:nth-child(3) { width: 14%; }
.comparison th:nth-child(4) { width: 23%; }
.how { color: #4a4a4a; font-size: .9em; }
.verdict { font-weight: 600; white-space: nowrap; }
.agrees { color: #00568a; }
.differs { color: #a33c00; }
.apart { color: #4a4a4a; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .2rem 1rem; margin: 1rem 0 0; font-size: .92rem; }
dt { color: #4a4a4a; }
dd { margin: 0; }
li p { margin: .2rem 0; }
@media screen and (max-width: 44rem) {
  body { padding: 1rem; }
  table, tbody, tr, th, td, caption { display: block; width: auto !important; }
  thead { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); }
  tr { padding: .6rem 0; border-bottom: 1px solid #b0b0b0; }
  th, td { padding: .1rem 0; border: 0; }
  tbody th { font-weight: 600; }
  td { display: grid; grid-template-columns: 8rem 1fr; gap: .5rem; }
  td::before { content: attr(data-column); color: #4a4a4a; }
  .summary td { display: inline-flex; gap: .35rem; margin-right: 1rem; }
  .plot { overflow-x: auto; }
  .plot .wide { max-width: none; width: 44rem; }
  dl { display: block; }
  dd { margin: 0 0 .5rem; }
}
@media print {
  :root { font-size: 9pt; }
  body { max-width: none; padding: 0; }
  h2, caption { break-after: avoid; }
  figure, tr, .note { break-inside: avoid; }
  code { background: none; padding: 0; }
}
"""
