"""The command ``gallop-fmu``, and the parts that ``gallop-modal`` shares."""
