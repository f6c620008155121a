# validate.py SCHEMAS FOLDER: checks result.json and manifest.json of a case and of its stages against the schemas of docs/schema.
# Prints one line per fault.
import json
import pathlib
import sys

import jsonschema

schemas, results = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
store = {name: json.loads((schemas / name).read_text()) for name in ("result.schema.json", "manifest.schema.json", "packing.schema.json")}
for schema in store.values():
    jsonschema.Draft202012Validator.check_schema(schema)


def check(file, schema, name):
    resolver = jsonschema.RefResolver("", store[name], store=store)
    for fault in jsonschema.Draft202012Validator(schema, resolver=resolver).iter_errors(json.loads(file.read_text())):
        print(f"{file.relative_to(results)}: {'/'.join(map(str, fault.absolute_path))}: {fault.message[:300]}")


if (results / "result.json").exists():
    check(results / "result.json", store["result.schema.json"], "result.schema.json")
for stage in sorted(folder for folder in results.iterdir() if (folder / "manifest.json").exists()):
    check(stage / "manifest.json", store["manifest.schema.json"], "manifest.schema.json")
    check(stage / "result.json", store["result.schema.json"]["$defs"][stage.name], "result.schema.json")
for packing in results.glob("pack/packing.json"):
    check(packing, store["packing.schema.json"], "packing.schema.json")
