//! What the messages of a recording look like, as JSON Schema. Those of Foxglove are told as far as they are used here,
//! under the names by which its panels know them.

use serde_json::{Value, json};

/// An object with these properties and no other; those of the list may be lacking.
fn object(title: &str, mut properties: Value, optional: &[&str]) -> Value {
    let map = properties.as_object_mut().expect("properties are an object");
    let required: Vec<String> = map.keys().filter(|key| !optional.contains(&key.as_str())).cloned().collect();
    json!({
        "title": title,
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

fn list(items: Value) -> Value {
    json!({"type": "array", "items": items})
}

fn told(ty: &str, description: &str) -> Value {
    json!({"type": ty, "description": description})
}

fn text(description: &str) -> Value {
    told("string", description)
}

fn number(description: &str) -> Value {
    told("number", description)
}

fn integer(description: &str) -> Value {
    told("integer", description)
}

/// The structure of a mission's tree.
pub(super) fn tree() -> Value {
    let node = json!({
        "id": integer("Its place in tree order; 0 is the root."),
        "name": text("What the mission calls it."),
        "kind": text("root, and, or, then, cleanup, or the kind of a behavior."),
        "parent": integer("The id of its parent; lacking for the root."),
    });
    let tree = json!({
        "mission": text("The mission's name."),
        "robot": text("The robot's name."),
        "allocator": text("How requests are chosen."),
        "nodes": list(object("ambidex.TreeNode", node, &["parent"])),
    });
    object("ambidex.Tree", tree, &[])
}

/// What nodes are.
pub(super) fn state() -> Value {
    let node = json!({
        "id": integer("Its place in tree order."),
        "name": text("What the mission calls it."),
        "kind": text("root, and, or, then, cleanup, or the kind of a behavior."),
        "phase": text("waiting, active, done, skipped, failed, canceled, not_asked or not_needed."),
        "reason": text("Why a behavior does not run, or at what it failed; lacking where there is nothing to say."),
    });
    let state = json!({
        "round": integer("How many rounds were decided."),
        "whole": told("boolean", "Whether these are all nodes; else those that are different now."),
        "nodes": list(object("ambidex.NodeState", node, &["reason"])),
    });
    object("ambidex.State", state, &[])
}

/// Who holds what.
pub(super) fn resources() -> Value {
    let holder = json!({
        "node": text("The node that holds it."),
        "behavior": text("The behavior that got it."),
        "kind": text("running, intention (kept for what its behavior was done for) or physical (the world is so)."),
    });
    let resource = json!({
        "id": integer("Its place in resource order."),
        "name": text("What the robot file calls it."),
        "type": text("gripper, head, base, or any other word."),
        "controller": text("Who moves it; lacking for one that only counts."),
        "access": text("free, exclusive or shared."),
        "channel": text("What it is shared for; lacking where it is not shared."),
        "holders": list(object("ambidex.Holder", holder, &[])),
        "holds": text("The object in it; lacking where none is."),
        "unavailable": text("Why nobody can be granted it; lacking where it is there."),
    });
    let optional = &["controller", "channel", "holds", "unavailable"];
    let resources = json!({"resources": list(object("ambidex.Resource", resource, optional))});
    object("ambidex.Resources", resources, &[])
}

/// A message, as `ambidex trace --json` prints it.
pub(super) fn message() -> Value {
    json!({
        "title": "ambidex.Message",
        "description": "A record of the log with names instead of ids, as `ambidex trace --json` prints it.",
        "type": "object",
        "properties": {
            "record": text("sent or controller."),
            "at": integer("Robot time, microseconds."),
            "round": integer("Of a message between nodes, the round it belongs to."),
            "from": text("The node that sent it."),
            "to": text("The node that gets it."),
            "controller": text("To or from which controller it went."),
            "message": {"type": "object", "properties": {"kind": text("What it is.")}, "required": ["kind"]},
        },
        "required": ["record", "at", "message"],
    })
}

/// That messages are missing.
pub(super) fn dropped() -> Value {
    let dropped = json!({
        "missing": integer("How many messages are missing just before this one, since the disk was too slow."),
        "total": integer("How many are missing so far."),
    });
    object("ambidex.Dropped", dropped, &[])
}

fn time(title: &str) -> Value {
    let parts = json!({
        "sec": {"type": "integer", "minimum": 0},
        "nsec": {"type": "integer", "minimum": 0, "maximum": 999_999_999},
    });
    object(title, parts, &[])
}

fn vector() -> Value {
    object("foxglove.Vector3", json!({"x": number("Meters."), "y": number("Meters."), "z": number("Meters.")}), &[])
}

fn quaternion() -> Value {
    let part = || json!({"type": "number"});
    object("foxglove.Quaternion", json!({"x": part(), "y": part(), "z": part(), "w": part()}), &[])
}

fn pose() -> Value {
    object("foxglove.Pose", json!({"position": vector(), "orientation": quaternion()}), &[])
}

fn color() -> Value {
    let part = || json!({"type": "number", "minimum": 0, "maximum": 1});
    object("foxglove.Color", json!({"r": part(), "g": part(), "b": part(), "a": part()}), &[])
}

/// Where the base is.
pub(super) fn pose_in_frame() -> Value {
    let pose = json!({
        "timestamp": time("time"),
        "frame_id": text("In which frame the pose is."),
        "pose": pose(),
    });
    object("foxglove.PoseInFrame", pose, &[])
}

/// Where frames are.
pub(super) fn frame_transforms() -> Value {
    let transform = json!({
        "timestamp": time("time"),
        "parent_frame_id": text("The frame in which it is."),
        "child_frame_id": text("The frame that is there."),
        "translation": vector(),
        "rotation": quaternion(),
    });
    let transforms = json!({"transforms": list(object("foxglove.FrameTransform", transform, &[]))});
    object("foxglove.FrameTransforms", transforms, &[])
}

/// What is seen of things.
pub(super) fn scene_update() -> Value {
    let deletion = json!({
        "timestamp": time("time"),
        "type": {"title": "foxglove.SceneEntityDeletionType", "oneOf": [
            {"title": "MATCHING_ID", "const": 0},
            {"title": "ALL", "const": 1},
        ]},
        "id": text("Of which thing nothing is seen any more."),
    });
    let cube = json!({"pose": pose(), "size": vector(), "color": color()});
    let cylinder = json!({
        "pose": pose(),
        "size": vector(),
        "bottom_scale": number("How wide its bottom is, of its size."),
        "top_scale": number("How wide its top is, of its size."),
        "color": color(),
    });
    let label = json!({
        "pose": pose(),
        "billboard": told("boolean", "Whether it faces whoever looks."),
        "font_size": number("Height of a line."),
        "scale_invariant": told("boolean", "Whether it has that height on the screen, in pixels."),
        "color": color(),
        "text": text("What it says."),
    });
    let unused = || list(json!({"type": "object"}));
    let entity = json!({
        "timestamp": time("time"),
        "frame_id": text("In which frame the thing is."),
        "id": text("What replaces another of the same id."),
        "lifetime": time("duration"),
        "frame_locked": told("boolean", "Whether it goes with its frame."),
        "metadata": unused(),
        "arrows": unused(),
        "cubes": list(object("foxglove.CubePrimitive", cube, &[])),
        "spheres": unused(),
        "cylinders": list(object("foxglove.CylinderPrimitive", cylinder, &[])),
        "lines": unused(),
        "triangles": unused(),
        "texts": list(object("foxglove.TextPrimitive", label, &[])),
        "models": unused(),
    });
    let update = json!({
        "deletions": list(object("foxglove.SceneEntityDeletion", deletion, &[])),
        "entities": list(object("foxglove.SceneEntity", entity, &[])),
    });
    object("foxglove.SceneUpdate", update, &[])
}

/// A line of talk.
pub(super) fn log() -> Value {
    let levels = ["UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL"];
    let levels: Vec<Value> =
        levels.iter().enumerate().map(|(level, title)| json!({"title": title, "const": level})).collect();
    let log = json!({
        "timestamp": time("time"),
        "level": {"title": "foxglove.LogLevel", "oneOf": levels},
        "message": text("What is said."),
        "name": text("Of what: the mission."),
        "file": text("Empty."),
        "line": integer("0."),
    });
    object("foxglove.Log", log, &[])
}
