"""The report of a campaign, one HTML file that opens without internet; tables and figures as printed."""
