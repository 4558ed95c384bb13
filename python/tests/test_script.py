"""The script of docs/python.md, with a shorter end so that it takes seconds."""

import math

import numpy


def test_the_script(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    import meniscus as mn

    scene = mn.Scene("drop-on-soft-plate", quality="draft")
    scene["tension.plate.contact_angle"] = "110 deg"
    scene["domain.quality.draft"] = 32  # coarser than a draft, and a coarser mesh
    scene["solid.plate.mesh.edge"] = "0.4 mm"
    scene["output.frame_interval"] = "1 ms"
    report = scene.check()
    print(report)
    assert "Bo = " in capsys.readouterr().out and report["bond"] > 0
    with scene.start("out/soft", resume=True) as sim:
        for frame in sim.frames(until="2 ms"):
            tip = frame.solid("plate").displacement[:, 2].min()
            print(f"{frame.time:.4f} s  {frame.angle('plate'):.1f} deg  {tip * 1e3:.2f} mm")
            if abs(frame.ledger.volume_error) > 1e-4:
                break
    frame.mesh("liquid").save("last.usda")
    assert "def Mesh" in (tmp_path / "last.usda").read_text()
    page = sim.page()
    assert page.is_file() and sim.summary["exit_reason"] == "finished"
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 3 and lines[2].startswith("0.0020 s"), lines
    solid(frame)

    scene["output.duration"] = "0.5 ms"
    table = mn.sweep(scene, {"tension.plate.contact_angle": ["60 deg", "90 deg", "120 deg"]}, jobs=2)
    assert list(table["tension.plate.contact_angle"]) == [60.0, 90.0, 120.0]
    assert list(table["state"]) == ["finished"] * 3


def solid(frame):
    """A soft solid in 3D has elements with tensors."""
    plate = frame.solid("plate")
    assert plate.displacement.shape == plate.positions.shape
    elements = plate.elements
    count = len(elements.positions)
    assert elements.simplices.shape[1] == 4 and elements.simplices.max() < count
    assert elements["stress"].shape == (count, 3, 3)
    assert elements["green_strain"].shape == (len(elements.simplices), 3, 3)
    assert elements["velocity"].shape == (count, 3) and numpy.isfinite(elements["strain"]).all()
    assert frame.phi.ndim == 3 and frame.velocity.shape == frame.phi.shape + (3,)
    assert math.isfinite(frame.ledger.elastic_energy) and len(frame.axes) == 3
