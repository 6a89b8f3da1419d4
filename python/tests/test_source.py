"""The source package that ``maturin sdist`` makes can be built by pip."""

import pathlib
import subprocess
import sys
import tarfile

ROOT = pathlib.Path(__file__).resolve().parents[1]


def maturin(*arguments, folder):
    done = subprocess.run([sys.executable, "-m", "maturin", *arguments], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_pip_can_read_the_metadata_of_the_source_package(tmp_path):
    # The workspace in the package has fewer members than the workspace of the lock file.
    maturin("sdist", "--out", str(tmp_path), folder=ROOT)
    (package,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(package) as archive:
        archive.extractall(tmp_path, filter="data")
    (tmp_path / "metadata").mkdir()
    source = tmp_path / package.name.removesuffix(".tar.gz")
    maturin("pep517", "write-dist-info", "--metadata-directory", str(tmp_path / "metadata"), folder=source)
    (found,) = (tmp_path / "metadata").glob("*.dist-info/METADATA")
    assert "\nName: isomend\n" in found.read_text()
