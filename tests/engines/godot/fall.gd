# Drops the pieces of each GLB file of the project on a floor, 8 s at 60 steps a second, and prints for each file:
#   NAME.glb bodies COUNT fell COUNT speed M/S below COUNT
# fell: by a tenth of a metre or more. speed: of the fastest piece at the end. below: pieces under the floor.
#   godot3-server --path PROJECT -s fall.gd --fixed-fps 60
extends SceneTree

const FLOOR = -1.5 # m, the pieces stand half a metre above it
var files = []
var scenes = []
var bodies = []
var heights = []
var step = 0

func _init():
	var folder = Directory.new()
	folder.open("res://")
	folder.list_dir_begin(true, true)
	var name = folder.get_next()
	while name != "":
		if name.ends_with(".glb"):
			files.append(name)
		name = folder.get_next()
	files.sort()
	for k in files.size():
		var shape = BoxShape.new()
		shape.extents = Vector3(20, 1, 20)
		var collision = CollisionShape.new()
		collision.shape = shape
		var ground = StaticBody.new()
		ground.add_child(collision)
		ground.translation = Vector3(100 * k, FLOOR - 1, 0)
		get_root().add_child(ground)
		var scene = load("res://" + files[k]).instance()
		scene.translation = Vector3(100 * k, 0, 0)
		get_root().add_child(scene)
		scenes.append(scene)
		bodies.append(bodies_of(scene))
		var height = []
		for body in bodies[k]:
			height.append(body.global_transform.origin.y)
		heights.append(height)

func bodies_of(node):
	var found = [node] if node is RigidBody else []
	for child in node.get_children():
		found += bodies_of(child)
	return found

func _iteration(_delta):
	step += 1
	if step < 480:
		return false
	for k in files.size():
		var speed = 0.0
		var below = 0
		var fell = 0
		for i in bodies[k].size():
			var body = bodies[k][i]
			var height = body.global_transform.origin.y
			speed = max(speed, body.linear_velocity.length())
			below += int(height < FLOOR)
			fell += int(height < heights[k][i] - 0.1)
		print(files[k], " bodies ", bodies[k].size(), " fell ", fell, " speed ", speed, " below ", below)
	quit()
	return false
