"""The desk in the browser: a person looks at runs, corrects them, and keeps the corrections in the CSV.

`server` answers the page, `desk` holds a campaign, `reprocessing` processes a record again by the workflow's
jobs, `csv_edit` writes cells.
"""
