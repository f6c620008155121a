"""The table of a study as a DataFrame of pandas. Usage: pandas_study.py FOLDER_OF_A_STUDY"""

import sys

import pandas

import porepack

study = porepack.Study(sys.argv[1])
table = pandas.DataFrame(study.table())
print(study)
print(table.groupby("shape.kind")["permeability_m2"].describe()[["count", "min", "max"]])
