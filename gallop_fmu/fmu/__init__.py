"""A span as an FMU for co-simulation (FMI 2.0): export, checks, and the table of variables."""

from gallop_fmu.fmu.check import FmuCheck, check_fmu
from gallop_fmu.fmu.export import ExportError, export_fmu
from gallop_fmu.fmu.variables import variable_table

__all__ = ["ExportError", "FmuCheck", "check_fmu", "export_fmu", "variable_table"]
