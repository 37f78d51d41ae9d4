"""Makes the wheel of seam_sdk and seam_gym, by PEP 517, with the standard library alone: a wheel is an archive with a list of its
files. Its version is that of the CMake project.
"""
import base64
import hashlib
import pathlib
import re
import shutil
import subprocess
import tempfile
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PROTO = "seam/v1/simulation.proto"
EPOCH = (1980, 1, 1, 0, 0, 0)  # The same bytes each time.


def version():
    return re.search(r"project\(seam VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())[1]


def stubs():
    """The modules made from proto/, by name."""
    protoc, plugin = shutil.which("protoc"), shutil.which("grpc_python_plugin")
    if not protoc or not plugin:
        raise SystemExit("seam-sdk: protoc or grpc_python_plugin is missing "
                         "(Debian: protobuf-compiler, protobuf-compiler-grpc)")
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([protoc, f"--python_out={folder}", f"--pyi_out={folder}", f"--grpc_out={folder}",
                        f"--plugin=protoc-gen-grpc={plugin}", "-I", ROOT / "proto", PROTO], check=True)
        made = pathlib.Path(folder)
        return {str(path.relative_to(made)): path.read_bytes() for path in sorted(made.rglob("*.py*"))}


def metadata():
    return (f"Metadata-Version: 2.1\nName: seam-sdk\nVersion: {version()}\n"
            "Summary: Client library for behaviours of robots in SEAM\nRequires-Python: >=3.9\n"
            "Requires-Dist: grpcio\nRequires-Dist: protobuf\n"
            "Provides-Extra: gym\nRequires-Dist: numpy; extra == 'gym'\n")


def get_requires_for_build_wheel(config_settings=None):
    return []


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    info = f"seam_sdk-{version()}.dist-info"
    files = {f"{name}/{path.name}": path.read_bytes() for name in ("seam_sdk", "seam_gym")
             for path in sorted((HERE / name).glob("*")) if path.suffix in (".py", ".typed")}
    files.update(stubs())
    files[f"{info}/METADATA"] = metadata().encode()
    files[f"{info}/WHEEL"] = b"Wheel-Version: 1.0\nGenerator: seam\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
    record = ""
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(content)}\n"
    files[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    name = f"seam_sdk-{version()}-py3-none-any.whl"
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, content in files.items():
            wheel.writestr(zipfile.ZipInfo(path, EPOCH), content)
    return name
