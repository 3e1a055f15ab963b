"""Comparison with a history of another program

A CSV file in its own units, with Y into the wall, beside a run.
"""

import tailslap

result = tailslap.run("paper-table-3")
columns = {"time": "TIME", "v_gx": "V1", "v_gy": "-V2", "omega": "VR3"}
compared = tailslap.compare(result, "../../examples/abaqus.csv", columns=columns)
compared.plot("v_gx", "v_gy", "omega").save("other_program.svg")
