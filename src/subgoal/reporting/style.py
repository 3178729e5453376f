"""The look of the report: one stylesheet, no fonts or files from elsewhere."""

from __future__ import annotations

from subgoal.plots.style import ALARM, FAINT, INK

CSS = f"""
:root {{ color-scheme: light; }}
* {{ box-sizing: border-box; }}
body {{ margin: 0; background: #f6f7f9; color: {INK};
    font: 15px/1.45 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }}
main {{ max-width: 1360px; margin: 0 auto; padding: 14px 20px 60px; overflow-wrap: anywhere; }}
.eyebrow {{ color: {FAINT}; font-size: 13px; margin: 0; }}
h1 {{ font-size: 25px; line-height: 1.2; margin: 2px 0 4px; }}
h2 {{ font-size: 18px; margin: 0 0 4px; }}
.sub {{ margin: 0 0 8px; color: {FAINT}; }}
.badge {{ display: inline-block; border-radius: 8px; padding: 5px 12px; margin: 0 0 10px; border: 1px solid; }}
.badge b {{ letter-spacing: .03em; }}
.good {{ color: #05603a; background: #ecfdf3; border-color: #6ce9a6; }}
.bad {{ color: {ALARM}; background: #fef3f2; border-color: #fda29b; }}
section, .card {{ background: #fff; border: 1px solid #e4e7ec; border-radius: 10px; padding: 14px 16px;
    margin: 0 0 14px; }}
.first {{ display: grid; gap: 14px; grid-template-columns: minmax(0, 1fr); }}
.pair {{ display: grid; gap: 14px; grid-template-columns: minmax(0, 1fr); }}
@media (min-width: 1000px) {{
  .first {{ grid-template-columns: minmax(0, 1.1fr) minmax(0, 1fr); align-items: start; }}
  .pair {{ grid-template-columns: minmax(0, 1fr) minmax(0, 1fr); }}
}}
.plot {{ width: 100%; overflow: hidden; }}
table {{ border-collapse: collapse; width: 100%; font-size: 13.5px; font-variant-numeric: tabular-nums; }}
th {{ text-align: left; color: {FAINT}; font-weight: 600; border-bottom: 1px solid #d0d5dd; padding: 4px 6px;
    vertical-align: bottom; }}
td {{ border-bottom: 1px solid #eef0f3; padding: 5px 6px; vertical-align: top; }}
th, td:not(:first-child) {{ overflow-wrap: normal; }}
td small {{ white-space: nowrap; color: {FAINT}; display: block; }}
.chip {{ display: inline-block; min-width: 22px; height: 22px; line-height: 22px; border-radius: 11px;
    padding: 0 5px;
  text-align: center; font-weight: 700; font-size: 12px; margin-right: 5px; }}
.note {{ color: {FAINT}; font-size: 13px; margin: 6px 0 0; }}
details > summary {{ cursor: pointer; font-weight: 600; font-size: 18px; }}
details[open] > summary {{ margin-bottom: 8px; }}
dl {{ margin: 0; }} dt {{ font-weight: 600; margin-top: 6px; }} dd {{ margin: 0 0 0 14px; color: #475467; }}
.faint {{ color: {FAINT}; }}
.fail {{ color: {ALARM}; font-weight: 600; }}
@media (max-width: 640px) {{
  main {{ padding: 10px 10px 40px; }}
  h1 {{ font-size: 21px; }}
  section, .card {{ padding: 10px; }}
  table.stack thead {{ display: none; }}
  table.stack tr {{ display: block; border-bottom: 1px solid #d0d5dd; padding: 6px 0; }}
  table.stack td {{ display: flex; justify-content: space-between; gap: 12px; border: 0; padding: 2px 0;
    text-align: right; }}
  table.stack td::before {{ content: attr(data-label); color: {FAINT}; text-align: left; }}
  table.stack td small {{ display: inline; }}
}}
@media print {{ body {{ background: #fff; }} section, .card {{ break-inside: avoid; }} }}
"""
