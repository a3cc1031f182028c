"""One line a case of a record: its name, the digest of its trace, its verdict and what it measured."""

import json
import sys

for case in json.load(open(sys.argv[1]))["cases"]:
    print(case["name"], case.get("trace_sha256"), case["verdict"], json.dumps(case.get("measurements"), sort_keys=True))
