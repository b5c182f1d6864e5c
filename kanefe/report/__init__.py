"""Reports: what a flexible body is, as text, Markdown and HTML."""

from kanefe.report.body import body_report as body_report
from kanefe.report.document import Report as Report
