"""Design indicators of galloping: frequency ratio, stability criteria, critical wind speed."""
