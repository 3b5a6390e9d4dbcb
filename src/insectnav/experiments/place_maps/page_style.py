"""How the page of a map looks beyond the report's style: on a desk, on a phone, on paper, by day and by night."""

from insectnav.experiments.report_style import STYLE as REPORT_STYLE

STYLE = (
    REPORT_STYLE
    + """
:root { color-scheme: light dark; }
h2 { margin-bottom: .6rem; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(9.5rem, 1fr)); gap: .75rem; margin: 1.25rem 0 0;
  padding: 0; list-style: none; }
.tiles li { border: 1px solid #dcdcdc; border-radius: 6px; padding: .6rem .8rem; }
.tiles strong { display: block; font-size: 1.5rem; line-height: 1.25; font-weight: 600;
  font-variant-numeric: tabular-nums; }
.tiles span { font-size: .85rem; color: #4a4a4a; }
.pairs { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 17rem), 1fr)); gap: 1rem; }
.pair { margin: 0; border: 1px solid #dcdcdc; border-radius: 6px; padding: .6rem; }
.pair img { width: 100%; height: auto; margin-bottom: .3rem; border-radius: 3px; }
.pair img.small { image-rendering: pixelated; }
.pair figcaption { font-size: .85rem; margin: 0; }
.pair strong { display: block; }
.right { color: #00694d; }
.wrong { color: #a33c00; }
.numbers { max-width: 60rem; }
.numbers th:first-child { width: 30%; }
.numbers th:nth-child(2) { width: 16%; }
@media (prefers-color-scheme: dark) {
  body { background: #15171a; color: #e4e4e4; }
  a { color: #8cc8f0; }
  code { background: #282b30; }
  section, th, td, .tiles li, .pair { border-color: #3b3f45; }
  thead th { border-color: #7d828a; }
  .tiles span, .source, figcaption, dt, .how, td::before { color: #b4b8be !important; }
  .note { background: #2c2119; border-color: #d98546; }
  .plot img { background: #fff; border-radius: 4px; padding: 4px; }
  .right { color: #52c9a2; }
  .wrong { color: #f0975e; }
}
@media print {
  body { background: #fff; color: #000; }
  .pair { break-inside: avoid; }
}
"""
)
