#!/bin/sh
# Writes the model of a uniform RC ladder of N sections, driven by a step, with an open end:
#   tools/rc_ladder.sh 10 > tests/data/models/rc_ladder_10.json
set -eu
n=$1
half=$((n / 2))
awk -v n="$n" -v half="$half" 'BEGIN {
  printf "{\n  \"bgsim\": 1, \"name\": \"rc_ladder_%d\",\n", n
  printf "  \"about\": \"Uniform RC ladder of %d sections, step input, open end; written by tools/rc_ladder.sh %d\",\n", n, n
  printf "  \"source\": \"closed form: rates 4/(R C) sin^2((2 k - 1) pi/(2 (2 N + 1)))\",\n"
  printf "  \"parameters\": { \"E\": 1, \"R\": 100, \"C\": 1e-7 },\n  \"elements\": {\n"
  printf "    \"source\": { \"kind\": \"Se\", \"effort\": \"E\" }"
  for (i = 1; i <= n; ++i) {
    printf ",\n    \"line%d\": { \"kind\": \"1\" }, \"r%d\": { \"kind\": \"R\", \"resistance\": \"R\" }", i, i
    printf ", \"end%d\": { \"kind\": \"0\" }, \"c%d\": { \"kind\": \"C\", \"capacitance\": \"C\" }", i, i
  }
  printf "\n  },\n  \"bonds\": [\n"
  for (i = 1; i <= n; ++i) {
    from = i == 1 ? "source" : "end" (i - 1)
    printf "    { \"from\": \"%s\", \"to\": \"line%d\" }, { \"from\": \"line%d\", \"to\": \"r%d\" }", from, i, i, i
    printf ", { \"from\": \"line%d\", \"to\": \"end%d\" }, { \"from\": \"end%d\", \"to\": \"c%d\" }%s\n", i, i, i, i, i < n ? "," : ""
  }
  printf "  ],\n  \"outputs\": { \"v1\": \"end1.e\", \"v%d\": \"end%d.e\", \"v%d\": \"end%d.e\" },\n", half, half, n, n
  stop = n == 10 ? "1e-3" : "1e-5*" n * n
  printf "  \"scenes\": { \"trace\": { \"stop\": \"%s\", \"samples\": 101, \"relative\": 1e-10,\n", stop
  printf "    \"reference\": { \"file\": \"../traces/ana_rc_ladder_%d.csv\", \"relative\": 1e-7 } } }\n}\n", n
}'
