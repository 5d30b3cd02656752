"""Record files: one reader per format behind read_record."""
