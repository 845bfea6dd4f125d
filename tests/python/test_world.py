import brittle
import numpy as np
import pytest


def shoot_at_a_vase(threads: int) -> tuple:
    world = brittle.World(threads=threads)
    vase = world.add(brittle.shape("vase"), material="ceramic", min_size=0.03, position=(0, 0.5, 0))
    events = world.events()
    assert [piece.object for piece in events.added] == [vase] and events.added[0].parent is None
    world.shoot((0, 0.7, 2), (0, 0, -15), radius=0.08)
    world.step(60)
    return world, events.added[0], world.events()


def test_a_ball_breaks_a_vase():
    world, whole, events = shoot_at_a_vase(threads=1)
    assert whole.piece in events.removed[:, 0]
    assert len(events.added) > 5 and all(piece.depth >= 1 for piece in events.added)
    poses = world.transforms()
    assert {piece.piece for piece in events.added} - set(events.removed[:, 0]) <= set(poses["piece"])
    assert np.linalg.norm(poses["orientation"], axis=1) == pytest.approx(1, abs=1e-4)
    assert poses["position"][:, 1].min() > -0.05  # nothing falls through the ground


def test_state_does_not_depend_on_the_number_of_threads():
    assert len({shoot_at_a_vase(threads)[0].state_hash for threads in (1, 2, 7)}) == 1


def test_pieces_of_a_fracture_hold_together_until_struck():
    world = brittle.World()
    broken = brittle.fracture(brittle.box((0.4, 1.0, 0.1)), 12)
    wall = world.add(broken, material="glass", strength=0.1, position=(0, 0.5, 0), anchors=[((0, -0.5, 0), 0.15)])
    added = world.events().added
    assert len(added) == 12 and all(piece.object == wall for piece in added)
    world.step(30)
    centres = np.array([piece.center_mass for piece in added]) + [0, 0.5, 0]
    assert world.transforms()["position"] == pytest.approx(centres, abs=1e-3)
    assert world.strike(added[0].piece, centres[0], (0, 0, -1), 400.0)
    world.step(30)
    poses = world.transforms()
    assert max(np.linalg.norm(poses["position"][k] - centres[k]) for k in range(min(12, len(poses)))) > 0.05
    world.remove(wall)
    world.step()
    assert len(world.transforms()) == 0


def test_a_ball_falls_as_fast_as_gravity():
    world = brittle.World(ground=None, gravity=(0, -10, 0), step=0.01)
    ball = world.shoot((1, 2, 3), (1, 0, 0))
    world.step(100)
    position, orientation = world.body(ball)
    assert position == pytest.approx([2, 2 - 5.0, 3], abs=0.06)  # within one step of explicit Euler
    assert orientation == pytest.approx([0, 0, 0, 1])


def test_arguments_that_cannot_be_used():
    world = brittle.World()
    with pytest.raises(ValueError, match="engine"):
        brittle.World(engine="physx")
    with pytest.raises(ValueError, match="rubber"):
        world.add(brittle.shape("cube"), material="rubber")
    with pytest.raises(ValueError, match="position has 2 numbers"):
        world.add(brittle.shape("cube"), position=(0, 0))
    with pytest.raises(ValueError, match="77"):
        world.strike(77, (0, 0, 0), (0, 0, 1), 1.0)
    with pytest.raises(ValueError, match="steps"):
        world.step(-1)
