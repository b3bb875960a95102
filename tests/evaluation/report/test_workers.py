"""Processes that measure end when whoever started them does, and so do their tools."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import active_children, get_context
from pathlib import Path

from evaluation.comparison import figures
from sim.tools import run
from tests.support.processes import wait_for_end, wait_for_number


def test_workers_are_ended_with_their_tools(tmp_path: Path) -> None:
    command = ["sh", "-c", "echo $$ > number; sleep 60"]
    with ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=figures._end_in_order) as pool:
        for _ in range(3):
            pool.submit(run, command, folder=tmp_path)
        number = wait_for_number(tmp_path / "number")
        pool.shutdown(wait=False, cancel_futures=True)
        figures._end_workers()
        assert active_children() == []
    wait_for_end(number)
