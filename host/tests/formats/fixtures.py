# Makes the files of other programs that the tests of host/tests/formats/main.rs read: python fixtures.py, with the packages of the README.
import os

import h5py
import numpy as np
import pyarrow
import pyarrow.parquet
import scipy.io
import xlwt
from odf.opendocument import OpenDocumentSpreadsheet
from odf.table import Table, TableCell, TableRow
from odf.text import P

here = os.path.dirname(os.path.abspath(__file__))
time = np.arange(60) / 100.0
voltage = np.where(np.arange(60) // 15 % 2 == 0, 4.5, -3.25)
speed = np.round(6 * np.sin(4 * time), 3)
angle = np.round(1.5 - 1.5 * np.cos(4 * time), 4)
run = {"time_s": time, "voltage_v": voltage, "angle_rad": angle, "speed_rad_s": speed, "gains": np.array([1.0, 2.0])}

for packed, name in [(True, "v7.mat"), (False, "v6.mat")]:
    scipy.io.savemat(os.path.join(here, name), run | {"note": "made for a test"}, do_compression=packed)
scipy.io.savemat(os.path.join(here, "struct.mat"), {"run": {"t": time, "motor": {"u": voltage, "pos": angle}}})

# The layout of MATLAB 7.3: HDF5 behind a text of 512 bytes, a vector as a matrix, its class as an attribute.
path = os.path.join(here, "v73.mat")
with h5py.File(path, "w", userblock_size=512) as file:
    for name, values in run.items():
        file.create_dataset(name, data=values.reshape(1, -1), compression="gzip", chunks=True)
        file[name].attrs["MATLAB_class"] = np.bytes_("double")
    table = file.create_dataset("T", data=np.array([[1, 2, 3, 4, 5, 6]], dtype="u4"))
    table.attrs["MATLAB_class"] = np.bytes_("timetable")
    table.attrs["MATLAB_object_decode"] = np.int32(3)
with open(path, "r+b") as file:
    text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64"
    file.write(text.ljust(124) + b"\x00\x02IM")

# h5py with groups, and rows as one dataset.
with h5py.File(os.path.join(here, "groups.h5"), "w") as file:
    file["run/t"] = time
    file["run/u"] = voltage.astype("f4")
    rows = np.zeros(60, dtype=[("q", "<f8"), ("n", "<i2")])
    rows["q"] = angle
    file["table"] = rows

# Spreadsheets of other programs, with a title above the names.
names = ["time_s", "voltage_v", "angle_rad", "speed_rad_s"]
rows = list(zip(time, voltage, angle, speed))
book = xlwt.Workbook()
sheet = book.add_sheet("run")
sheet.write(0, 0, "a run of the motor")
for column, name in enumerate(names):
    sheet.write(2, column, name)
    for row, values in enumerate(rows):
        sheet.write(3 + row, column, float(values[column]))
book.save(os.path.join(here, "sheet.xls"))

document = OpenDocumentSpreadsheet()
table = Table(name="run")
for values in [names, *rows]:
    row = TableRow()
    for value in values:
        is_text = isinstance(value, str)
        cell = TableCell(valuetype="string") if is_text else TableCell(valuetype="float", value=repr(float(value)))
        cell.addElement(P(text=str(value)))
        row.addElement(cell)
    table.addElement(row)
document.spreadsheet.addElement(table)
document.save(os.path.join(here, "sheet.ods"))

# As LeRobot stores an episode: lists with a value per joint.
pyarrow.parquet.write_table(
    pyarrow.table(
        {
            "timestamp": time,
            "action": [[float(v), 0.0] for v in voltage],
            "observation.state": [[float(a), float(s)] for a, s in zip(angle, speed)],
        }
    ),
    os.path.join(here, "lists.parquet"),
)
