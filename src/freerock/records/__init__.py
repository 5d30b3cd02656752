"""Record files: one module per format behind `read.read_record`, all of them on an even time base."""
