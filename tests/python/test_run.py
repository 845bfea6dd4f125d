import json
import threading

import brittle
import numpy as np
import pytest

STONE = {"brittle": 1, "mesh": "shape:cube", "material": "stone", "world": {"breakable": True, "height": 0}}
ROOM = {"brittle": 2, "objects": [
    {"name": "floor", "mesh": "shape:cube", "fixed": True, "scale": [2, 0.1, 2], "translation": [0, 0.05, 0]},
    {"name": "vase", "mesh": "shape:vase", "material": "ceramic", "scale": [0.3, 0.3, 0.3], "translation": [0, 1, 0]},
    {"name": "block", "mesh": "shape:cube", "material": "stone", "bonded": True, "pattern": {"count": 5},
     "scale": [0.3, 0.3, 0.3], "translation": [0.7, 1, 0]}]}


def shot_at(recipe: dict, threads: int) -> brittle.Run:
    run = brittle.Recipe(recipe).run(threads=threads)
    run.step(4)
    run.shoot((0, 1, 4), (0, 0, -25), radius=0.2)
    run.step(60)
    return run


def test_a_recipe_gives_the_pieces_of_its_settings(tmp_path):
    recipe = brittle.Recipe({"brittle": 1, "mesh": "shape:torus", "pattern": {"count": 20, "seed": 5, "inside": True}})
    assert recipe.to_dict()["pattern"]["seed"] == 5
    broken = recipe.fracture()
    by_hand = brittle.fracture(brittle.shape("torus"), 20, seed=5)
    assert broken.certificate.hash == by_hand.certificate.hash and broken.certificate.closed
    recipe.save(tmp_path / "torus.json")
    again = brittle.Recipe(tmp_path / "torus.json")
    assert again.to_dict() == recipe.to_dict()
    assert again.fracture(threads=1).certificate.hash == broken.certificate.hash


def test_paths_of_a_mapping_count_from_its_folder(tmp_path):
    brittle.box((1, 2, 3)).export(tmp_path / "box.obj")
    recipe = brittle.Recipe({"brittle": 1, "mesh": "box.obj", "pattern": {"count": 4}}, folder=tmp_path)
    assert recipe.fracture().certificate.volume_input == pytest.approx(6.0)


@pytest.mark.parametrize("recipe, status, part", [
    ({"brittle": 1, "mehs": "shape:cube"}, "malformed_file", "mehs"),
    ({"brittle": 1, "mesh": "shape:cube", "pattern": {"count": -1}}, "malformed_file", "count"),
    ({"brittle": 7}, "malformed_file", "brittle"),
])
def test_recipes_are_refused_with_the_place_of_the_fault(recipe, status, part):
    with pytest.raises(brittle.BrittleError, match=part) as refused:
        brittle.Recipe(recipe)
    assert refused.value.status == status


def test_missing_files_and_scenes_are_refused(tmp_path):
    with pytest.raises(FileNotFoundError, match="nothing.json"):
        brittle.Recipe(tmp_path / "nothing.json")
    with pytest.raises(FileNotFoundError, match="nothing.log"):
        brittle.replay(tmp_path / "nothing.log")
    with pytest.raises(FileNotFoundError, match="nothing.obj"):
        brittle.Recipe({"brittle": 1, "mesh": "nothing.obj"}, folder=tmp_path).fracture()
    with pytest.raises(ValueError, match="scene"):
        brittle.Recipe(ROOM).fracture()
    with pytest.raises(TypeError, match="folder"):
        brittle.Recipe(tmp_path / "a.json", folder=tmp_path)


def test_a_ball_breaks_a_stone_the_same_way_with_any_number_of_threads():
    run = shot_at(STONE, 1)
    first = run.events()
    assert len(first.added) > 5
    assert run.steps == 64 and run.step_seconds == pytest.approx(1 / 120)
    assert run.balls()["radius"].tolist() == pytest.approx([0.2])
    poses = run.transforms()
    assert np.linalg.norm(poses["orientation"], axis=1) == pytest.approx(1, abs=1e-4)
    assert not run.events().added
    assert {shot_at(STONE, threads).state_hash for threads in (2, 7)} == {run.state_hash}


def test_a_scene_has_objects_with_their_pieces():
    run = brittle.Recipe(ROOM).run()
    floor, vase, block = run.objects()
    assert floor.fixed and floor.fracture is None and floor.mesh.bounds[1] - floor.mesh.bounds[0] == pytest.approx([4, 0.2, 4])
    assert (vase.name, vase.material, vase.piece_count) == ("vase", "ceramic", 1)
    assert vase.position == pytest.approx([0, 1, 0]) and vase.orientation == pytest.approx([0, 0, 0, 1])
    assert block.piece_count == 5 == len(block.fracture.pieces)
    assert run.notes == []
    assert len(run.transforms()) >= 6


def test_a_mesh_that_cannot_be_broken_is_noted(tmp_path):
    lines = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "f 1 2 3"]
    (tmp_path / "open.obj").write_text("\n".join(lines))
    run = brittle.Recipe({"brittle": 2, "objects": [{"name": "sheet", "mesh": "open.obj"}]}, folder=tmp_path).run()
    assert run.objects()[0].fixed and "sheet" in run.notes[0]


def test_actions_are_those_of_a_replay_log():
    run = brittle.Recipe({"brittle": 1, "mesh": "shape:cube", "pattern": {"count": 6},
                          "world": {"bonded": False, "height": 1}}).run()
    before = run.transforms()
    run.act("push", piece=2, point=before["position"][2], impulse=np.array([0, 0, 200.0]))
    run.step(1)
    moved = run.transforms()["position"][:, 2] - before["position"][:, 2]
    assert moved.argmax() == 2 and moved[2] > 1e-4
    with pytest.raises(brittle.BrittleError, match="jump"):
        run.act("jump")
    with pytest.raises(brittle.BrittleError, match="piece"):
        run.act("push", piece=99, point=[0, 0, 0], impulse=[0, 0, 1])


def test_logs_are_replayed_and_differences_are_found(tmp_path):
    run = shot_at(STONE, 2)
    log = tmp_path / "run.log"
    run.save_log(log)
    shares = []
    found = brittle.replay(log, progress=shares.append)
    assert found.equal and found.steps == 64 and found.actions == 1 and found.first_difference is None
    assert found.state_hash == run.state_hash and found.difference == ""
    assert shares == sorted(shares) and shares[-1] <= 1.0
    lines = [json.loads(line) for line in log.read_text().splitlines()]
    next(line for line in lines if "shoot" in line)["shoot"]["radius"] = 0.21
    log.write_text("\n".join(map(json.dumps, lines)) + "\n")
    changed = brittle.replay(log)
    assert not changed.equal and changed.first_difference == 5 and "state hash" in changed.difference
    log.write_text("nonsense\n")
    with pytest.raises(brittle.BrittleError, match="run.log") as refused:
        brittle.replay(log)
    assert refused.value.status == "malformed_file"


def test_cancelling_and_reports():
    told = []
    recipe = {"brittle": 1, "mesh": "shape:cube", "repair": True, "pattern": {"count": 3}}
    brittle.Recipe(recipe).fracture(report=told.append)
    assert told == ["cube: nothing to repair"]
    token = brittle.CancelToken()
    token.cancel()
    with pytest.raises(brittle.Cancelled):
        brittle.Recipe(recipe).fracture(cancel=token)
    with pytest.raises(brittle.Cancelled):
        brittle.Recipe(ROOM).run(cancel=token)

    def fail(_share):
        raise KeyError("mine")
    with pytest.raises(KeyError, match="mine"):
        brittle.Recipe(recipe).fracture(progress=fail)


def test_threads_share_a_run():
    run = shot_at(STONE, 1)
    counts = [len(run.transforms())]
    workers = [threading.Thread(target=lambda: counts.append(len(run.transforms()))) for _ in range(4)]
    for worker in workers:
        worker.start()
    run.step(5)
    for worker in workers:
        worker.join()
    assert len(counts) == 5 and min(counts) > 0
