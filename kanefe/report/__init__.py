"""The report of a flexible body."""

from kanefe.report.body import body_report as body_report
