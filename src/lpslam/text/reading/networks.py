"""The reading networks and the engine that runs them.

The models are PaddleOCR's PP-OCR (Apache-2.0) as they come in the rapidocr wheel; they are run from there directly, so
nothing is downloaded, logged or resized on the way.
"""

import importlib.util
import sys
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError

Engine = Literal["auto", "openvino", "onnxruntime"]


class Network(Protocol):
    """A network with one input and one output."""

    @property
    def alphabet(self) -> list[str]:
        """The characters stored with the model, in the order of its classes; empty for a detector."""
        ...

    def infer(self, batch: NDArray[np.float32]) -> NDArray[np.float32]:
        """Run (n, 3, h, w) through the network."""
        ...


class OpenVinoNetwork:
    """OpenVINO: about three times as fast as ONNX Runtime on x86."""

    def __init__(self, model: Path, threads: int) -> None:
        compiled, self._alphabet = compiled_model(model, threads)
        self._request = compiled.create_infer_request()

    @property
    def alphabet(self) -> list[str]:
        """See `Network`."""
        return self._alphabet

    def infer(self, batch: NDArray[np.float32]) -> NDArray[np.float32]:
        """See `Network`. The result is valid until the next call."""
        self._request.infer([batch])
        output: NDArray[np.float32] = self._request.get_output_tensor().data
        return output


def _openvino() -> Any:
    """OpenVINO without what reports its import to its makers over the network, and keeps a count in the user's home.

    It does without where that package is not installed; here it seems not to be while it is looked for.
    """
    is_hidden = _REPORTS not in sys.modules
    if is_hidden:
        sys.modules[_REPORTS] = None  # type: ignore[assignment]
    try:
        import openvino
    finally:
        if is_hidden:
            del sys.modules[_REPORTS]
    return openvino


_REPORTS = "openvino_telemetry"


def compiled_model(model: Path, threads: int) -> tuple[Any, list[str]]:
    """A model as OpenVINO runs it, with the characters stored in it."""
    core = _openvino().Core()
    graph = core.read_model(str(model))
    metadata: Any = graph.get_rt_info()
    stored = metadata["framework"] if "framework" in metadata else {}  # noqa: SIM401 - OVAny has no `get`
    alphabet = str(stored["character"].value).splitlines() if "character" in stored else []
    properties = {
        "INFERENCE_NUM_THREADS": threads,
        "NUM_STREAMS": 1,
        # bfloat16 would be twice as fast where the processor has it, and read differently where not.
        "INFERENCE_PRECISION_HINT": "f32",
    }
    return core.compile_model(graph, "CPU", properties), alphabet


class OnnxRuntimeNetwork:
    """ONNX Runtime: runs everywhere."""

    def __init__(self, model: Path, threads: int) -> None:
        import onnxruntime

        options = onnxruntime.SessionOptions()
        options.log_severity_level = 4
        options.intra_op_num_threads = threads
        options.inter_op_num_threads = 1
        self._session = onnxruntime.InferenceSession(str(model), options, providers=["CPUExecutionProvider"])
        self._input = self._session.get_inputs()[0].name
        metadata = self._session.get_modelmeta().custom_metadata_map
        self._alphabet: list[str] = metadata.get("character", "").splitlines()

    @property
    def alphabet(self) -> list[str]:
        """See `Network`."""
        return self._alphabet

    def infer(self, batch: NDArray[np.float32]) -> NDArray[np.float32]:
        """See `Network`."""
        output: NDArray[np.float32] = self._session.run(None, {self._input: batch})[0]
        return output


def load_network(task: Literal["det", "rec"], engine: Engine, threads: int) -> Network:
    """Load the detection or the recognition model of the rapidocr wheel.

    Raises:
        UserError: the wheel, its model or the wanted engine is not installed.
    """
    model = _model_path(task)
    if engine == "auto":
        engine = "openvino" if importlib.util.find_spec("openvino") else "onnxruntime"
    if importlib.util.find_spec(engine) is None:
        remedy = "pip install openvino" if engine == "openvino" else "pip install 'lp-slam[onnx]'"
        raise UserError(f"reading engine {engine} is not installed: {remedy}")
    return OpenVinoNetwork(model, threads) if engine == "openvino" else OnnxRuntimeNetwork(model, threads)


def _model_path(task: str) -> Path:
    # The package is only located: importing it would load its own engines and loggers.
    spec = importlib.util.find_spec("rapidocr")
    if spec is None or not spec.submodule_search_locations:
        raise UserError("the reading models are not installed: pip install 'rapidocr>=3.10,<4'")
    folder = Path(spec.submodule_search_locations[0]) / "models"
    models = sorted(folder.glob(f"*_{task}_*.onnx"))
    if not models:
        raise UserError(
            f"no reading model *_{task}_*.onnx in {folder}: pip install --force-reinstall 'rapidocr>=3.10,<4'"
        )
    return models[-1]
