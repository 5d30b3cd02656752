"""The desk in the browser: a person looks at runs, corrects them, and keeps the corrections in the CSV."""

__all__ = ["csv_edit"]
