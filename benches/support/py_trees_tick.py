"""The fastest tick, in seconds, of a parallel of N sequences of four behaviours that do not end."""

import sys
import time

import py_trees

asked = 0


class Step(py_trees.behaviour.Behaviour):
    def update(self):
        global asked
        asked += 1
        return py_trees.common.Status.RUNNING


n, samples = int(sys.argv[1]), int(sys.argv[2])
root = py_trees.composites.Parallel("all", policy=py_trees.common.ParallelPolicy.SuccessOnAll(synchronise=False))
for task in range(n):
    sequence = py_trees.composites.Sequence(f"task {task}", memory=True)
    sequence.add_children([Step(f"step {task} {step}") for step in range(4)])
    root.add_child(sequence)
root.tick_once()
fastest = float("inf")
for _ in range(samples):
    asked = 0
    begun = time.perf_counter()
    root.tick_once()
    fastest = min(fastest, time.perf_counter() - begun)
    assert asked == n, f"{asked} of {n} were asked"
print(fastest)
