"""Puts the networks, their model cards and the licence into a wheel; all else stands in pyproject.toml."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).parent


class BuildWithProjectFiles(build_py):
    """Copies what `psp_model/installed/files.py` looks for; an editable install finds it in the checkout."""

    def run(self) -> None:
        """Build, without what an earlier build left behind."""
        if self.editable_mode:
            super().run()
            return
        shutil.rmtree(self.build_lib, ignore_errors=True)
        super().run()
        for target, source in self._packed().items():
            self.mkpath(str(target.parent))
            self.copy_file(str(source), str(target))

    def get_outputs(self, include_bytecode: bool = True) -> list[str]:
        """Every file that is built."""
        packed = [] if self.editable_mode else [str(target) for target in self._packed()]
        return [*super().get_outputs(include_bytecode), *packed]

    def _packed(self) -> dict[Path, Path]:
        """The project's files, by where they go."""
        folder = Path(self.build_lib, "psp_model", "installed", "packed")
        sources = [*sorted((ROOT / "onnx").glob("*.onnx")), *sorted((ROOT / "onnx").glob("*.md")), ROOT / "LICENSE"]
        return {folder / source.relative_to(ROOT): source for source in sources}


setup(cmdclass={"build_py": BuildWithProjectFiles})
