"""ONNX policies of other programs, converted to policy.h5 (docs/export_policy.md)."""
