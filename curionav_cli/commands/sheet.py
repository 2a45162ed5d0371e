"""curionav sheet: pictures of a world, from above and from within."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.config.job import Outcome
from curionav_cli.config.schema import Config
from curionav_cli.execution.launch import Request, launch


def run(request: Request) -> int:
    """Carry out the command; returns the exit code."""
    return launch(request, work, summary, check)


def work(settings: Config, folder: Path) -> dict[str, Any]:
    """Draw the floor plan, a sheet of views, and the view from above alone, into `folder`."""
    from curionav_cli.results import floor_plans, plots  # matplotlib only when there is something to draw
    from curionav_cli.results.labels import scene_name
    from curionav_cli.world.contact_sheet import contact_sheet, plans

    world = build.scene(settings)
    cells, cell = int(world.plan.visitable.sum()), world.plan.cell
    name, area = scene_name(vars(settings.env)), cells * cell ** 2
    title = f"{name}: {cells:,} visitable cells of {cell * 100:g} cm, {area:,.2f} m2"
    plots.save(floor_plans.sheet(world.plan, title), folder / "plan.png")
    contact_sheet(world, folder / "sheet.png")
    plans([world], folder / "above.png")
    about = list(world.view.about) if world.view else []
    if counted := getattr(settings.env, "counted", None):
        about.append(f"others counted {counted} visitable cells there: ours are {cells / counted - 1:+.1%}")
    return {"cells": cells, "cell": cell, "about": about}


def check(settings: Config) -> None:
    """Check that the scene loads. Raises SceneError or MapError."""
    build.scene(settings)


def summary(folder: Path, outcomes: list[Outcome]) -> None:
    """Print the size of each world and where its pictures are."""
    for outcome in outcomes:
        if not outcome.code:
            area = outcome.result["cells"] * outcome.result["cell"] ** 2
            print(f"{outcome.folder / 'plan.png'} and sheet.png: {outcome.result['cells']} visitable cells of "
                  f"{outcome.result['cell'] * 100:g} cm, {area:.2f} m2")
            for line in outcome.result["about"]:
                print(f"  {line}")
