"""Holds the shipped studies and the default hammer to the schemas, and sees that the schemas refuse what is wrong.

Usage: python schemas.py ROOT (the folder with `schemas` and `studies`)
"""

import json
import pathlib
import sys
import tomllib

import jsonschema


def faults(schema, instance):
    """What a schema has against an instance, as text."""
    return [error.message for error in jsonschema.Draft202012Validator(schema).iter_errors(instance)]


def main(root):
    """All checks; the first that fails ends the program."""
    study_schema, hammer_schema = (
        json.loads((root / "schemas" / f"{name}.schema.json").read_text()) for name in ("study", "hammer")
    )
    files = {path: study_schema for path in sorted((root / "studies").glob("*.toml"))}
    files[root / "studies/hammers/default.toml"] = hammer_schema
    if len(files) < 5:
        sys.exit(f"schemas: only {len(files)} files found")
    for path, schema in files.items():
        jsonschema.Draft202012Validator.check_schema(schema)
        instance = tomllib.loads(path.read_text())
        if found := faults(schema, instance):
            sys.exit(f"schemas: {path}: {found}")
        wrong = instance | {"colour": 1}
        if not any("colour" in fault for fault in faults(schema, wrong)):
            sys.exit(f"schemas: {path}: an unknown key is not refused")
    if not faults(study_schema, {"hammer": {}, "casting": {}, "colour": 1}):
        sys.exit("schemas: a study of empty tables and an unknown key is not refused")
    print(f"schemas: {len(files)} files hold")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
