"""Trained policies for other programs: C sources and ONNX (docs/export_policy.md)."""
