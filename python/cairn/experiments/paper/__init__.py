"""Figures and tables of [Maalouf06] that are neither a drive nor a schedule, made from the code.

One file per idea: each measures something of the library and returns plain data with a `summary`.
"""
