# SPDX-License-Identifier: AGPL-3.0-or-later
"""What documents say about the package."""
import importlib.util
import re
import tempfile

import pytest
from conftest import SOURCE

import reference


def test_reference():
    """If it differs: PYTHONPATH=build/python tests/python/reference.py > docs/reference/python.md"""
    assert (SOURCE / "docs/reference/python.md").read_text() == reference.page()


@pytest.mark.parametrize("page, least", [("python", 5), ("realisations", 1)])
def test_howto(page, least, tmp_path, monkeypatch, pipe):
    """The Python blocks of a page run, one after the other, in the folder of a case."""
    monkeypatch.chdir(pipe)
    blocks = re.findall(r"^```python\n(.*?)^```", (SOURCE / f"docs/howto/{page}.md").read_text(), re.M | re.S)
    names = {}
    assert len(blocks) >= least
    for block in blocks:
        if "mpi4py" in block and not importlib.util.find_spec("mpi4py"):
            continue
        exec(compile(block, page + ".md", "exec"), names)


@pytest.mark.long
@pytest.mark.parametrize("name, pictures, written", [("packing", 2, ["cylinder/RBC.pos", "cylinder/cells.h5"]),
                                                     ("vessel", 2, ["vessel-*/case/case.cpp"])])
def test_notebook(name, pictures, written, tmp_path):
    """Beside what the other one, and this one before, have written."""
    if name == "packing":
        for folder in ("case", "cylinder"):
            (tmp_path / folder).mkdir()
            (tmp_path / folder / "RBC.pos").write_text("1\n0 0 0 0 0 0\n")
        (tmp_path / "cylinder/cells.h5").write_text("another file")
    nbformat, nbclient, traitlets = map(pytest.importorskip, ("nbformat", "nbclient", "traitlets.config"))
    notebook = nbformat.read(SOURCE / f"examples/{name}.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "stored without outputs"
    # Sockets in a folder, not ports: another program may take a port between its choice and its use.
    with tempfile.TemporaryDirectory() as sockets:
        settings = traitlets.Config({"KernelManager": {"transport": "ipc", "ip": f"{sockets}/s"}})
        # Time limits [s] that a loaded machine does not reach: of a cell, of the kernel's start, of its output's arrival.
        for _ in range(2):
            nbclient.NotebookClient(notebook, timeout=1200, startup_timeout=1200, iopub_timeout=1200, kernel_name="python3",
                                    config=settings, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert not [output for output in outputs if output.output_type == "error"]
    assert sum("image/png" in output.get("data", {}) for output in outputs) == pictures
    assert all(list(tmp_path.glob(file)) for file in written)
