"""From the text of a command to its SDC trees (section 3.1). Read ``sdc_parser`` first."""
