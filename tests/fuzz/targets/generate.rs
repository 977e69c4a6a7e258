//! Missions at random that load for the most part, as they would be written.

use ambidex::model::MissionSpec;
use serde_json::{Map, Value, json};

use crate::rng::Rng;

/// Most nodes between the top and a behavior.
const DEPTH: usize = 5;

struct Maker<'a> {
    rng: &'a mut Rng,
    places: Vec<String>,
    objects: Vec<String>,
    facts: Vec<String>,
    kinds: Vec<String>,
    subtrees: Vec<String>,
    names: usize,
    nodes: usize,
}

/// A mission for a robot that is shipped.
pub fn mission(rng: &mut Rng) -> Value {
    let named = |what: &str, count: usize| (0..count).map(|index| format!("{what} {index}")).collect::<Vec<_>>();
    let places = named("place", 1 + rng.below(6));
    let objects = named("object", rng.below(6));
    let facts = named("fact", 1 + rng.below(4));
    let mut maker = Maker { rng, places, objects, facts, kinds: Vec::new(), subtrees: Vec::new(), names: 0, nodes: 0 };
    let world = maker.world();
    let behaviors: Map<String, Value> =
        (0..maker.rng.below(5)).map(|index| (format!("act{index}"), maker.behavior())).collect();
    maker.kinds = behaviors.keys().cloned().collect();
    let mut subtrees = Map::new();
    for index in 0..maker.rng.below(3) {
        let (part, name) = (maker.node(2), format!("part{index}"));
        subtrees.insert(name.clone(), json!({"task": part}));
        maker.subtrees.push(name);
    }
    let task = maker.node(DEPTH);
    let robot = maker.rng.one(&["pr2", "lab", "porter", "carrier", "trio", "desk"]);
    let mut mission = json!({
        "mission": "random", "robot": format!("../robots/{robot}.yaml"), "world": world, "behaviors": behaviors,
        "subtrees": subtrees, "task": task
    });
    if maker.rng.is(20) {
        mission["bypass"] = json!(maker.rng.below(4));
    }
    mission
}

/// What goes wrong in it.
pub fn failures(mission: &MissionSpec, rng: &mut Rng) -> Value {
    let (names, count) = (&mission.names, rng.below(6));
    let mut failures = Vec::new();
    let one = |rng: &mut Rng, of: &[String]| (!of.is_empty()).then(|| of[rng.below(of.len())].clone());
    for _ in 0..count {
        let at = format!("{} s", rng.below(3000) as f64 / 100.0);
        let controller = one(rng, &names.controllers);
        let leaves: Vec<String> = mission.tree.leaves().map(|leaf| names.node(leaf).to_owned()).collect();
        let (leaf, fact) = (one(rng, &leaves), one(rng, &names.facts));
        failures.push(match rng.below(9) {
            0 => json!({"at": at, "lose": controller}),
            1 => json!({"at": at, "hang": controller}),
            2 => json!({"at": at, "inhibit": controller}),
            3 | 4 => json!({"at": at, "return": controller}),
            5 => json!({"at": at, "set": fact}),
            6 => json!({"behavior": leaf, "attempt": "every", "fails": "aborted"}),
            7 => json!({"behavior": leaf, "hangs": true}),
            _ => json!({"behavior": leaf, "drops": "all"}),
        });
    }
    failures.into()
}

impl Maker<'_> {
    fn one(&mut self, of: fn(&Self) -> &Vec<String>) -> String {
        let count = of(self).len();
        let index = self.rng.below(count);
        of(self)[index].clone()
    }

    fn place(&mut self) -> String {
        self.one(|maker| &maker.places)
    }

    fn fact(&mut self) -> String {
        self.one(|maker| &maker.facts)
    }

    fn world(&mut self) -> Value {
        let mut point = || json!([format!("{} m", self.rng.below(16)), format!("{} m", self.rng.below(16))]);
        let robot = json!({"at": point()});
        let places: Map<String, Value> =
            self.places.iter().map(|name| (name.clone(), json!({"stand": point()}))).collect();
        let objects: Map<String, Value> = self
            .objects
            .iter()
            .enumerate()
            .map(|(index, name)| (name.clone(), json!({"at": self.places[index % self.places.len()]})))
            .collect();
        let facts: Map<String, Value> = self
            .facts
            .iter()
            .enumerate()
            .map(|(index, name)| (name.clone(), json!({"holds": index % 3 == 0, "outside": index % 2 == 0})))
            .collect();
        let mut world = json!({"robot": robot, "places": places, "objects": objects, "facts": facts});
        if self.rng.is(40) {
            let [x, y] = [self.rng.below(14), self.rng.below(14)];
            world["obstacles"] = json!([{"min": [x, y], "max": [x + 1, y + self.rng.below(3) + 1]}]);
        }
        world
    }

    /// A kind that claims at random.
    fn behavior(&mut self) -> Value {
        let mut claims = Map::new();
        for index in 0..self.rng.below(3) {
            let mut claim =
                json!({"type": self.rng.one(&["base", "gripper", "head", "slot", "tool"]), "optional": true});
            match self.rng.below(4) {
                0 => claim["shared"] = json!("at it"),
                1 => claim["keep"] = json!({"for": "it"}),
                _ => {}
            }
            claims.insert(format!("claim{index}"), claim);
        }
        let (fact, other) = (self.fact(), self.fact());
        let mut behavior = json!({
            "claims": claims,
            "potential": self.rng.one(&[json!(1), json!(0), json!(1e9), json!("high")]),
            "takes": self.rng.one(&["0 s", "0.5 s", "3 s"]),
        });
        let mut add = |percent: usize, key: &str, value: Value| {
            if self.rng.is(percent) {
                behavior[key] = value;
            }
        };
        add(60, "effects", json!([{"set": fact}]));
        add(20, "effects", json!([{"clear": fact}]));
        add(40, "goal", json!([{"fact": fact}]));
        add(30, "precondition", json!([{"fact": other}]));
        add(15, "while", json!([{"not_fact": other}]));
        add(20, "timeout", json!("2 s"));
        add(20, "retries", json!(1000));
        add(20, "backoff", json!("0 s"));
        add(20, "interruptible", json!(true));
        behavior
    }

    fn node(&mut self, depth: usize) -> Value {
        self.nodes += 1;
        let mut node = match self.rng.below(10) {
            0..6 if depth > 0 && self.nodes < 60 => {
                let kind = self.rng.one(&["and", "and", "or", "then"]);
                let children: Vec<Value> = (0..1 + self.rng.below(4)).map(|_| self.node(depth - 1)).collect();
                json!({ kind: children })
            }
            _ => self.behavior_node(),
        };
        let is_composite = ["and", "or", "then"].iter().any(|kind| node.get(kind).is_some());
        let percent = if is_composite { 12 } else { 5 };
        let settings = [
            ("priority", json!(self.rng.below(3))),
            ("retries", json!(self.rng.below(4))),
            ("backoff", json!("0 s")),
            ("timeout", json!(format!("{} s", 1 + self.rng.below(30)))),
        ];
        for (key, value) in settings {
            if self.rng.is(percent) {
                node[key] = value;
            }
        }
        if is_composite && self.rng.is(8) {
            node["repeat"] = self.rng.one(&[json!(2), json!(50), json!("forever")]);
            if self.rng.is(50) {
                node["every"] = json!("0.5 s");
            }
        }
        if depth > 1 && self.rng.is(8) {
            node["cleanup"] = self.node(1);
        }
        self.names += 1;
        node["name"] = format!("node {}", self.names).into();
        node
    }

    fn behavior_node(&mut self) -> Value {
        let (from, to) = (self.place(), self.place());
        match self.rng.below(6) {
            0 | 1 if !self.objects.is_empty() => {
                let object = self.one(|maker| &maker.objects);
                let steps =
                    [json!({"move": from}), json!({"pick": object}), json!({"move": to}), json!({"place": object})];
                json!({"then": steps})
            }
            2 | 3 if !self.kinds.is_empty() => json!({self.one(|maker| &maker.kinds): {}}),
            4 if !self.subtrees.is_empty() => json!({"use": self.one(|maker| &maker.subtrees)}),
            _ => json!({"move": to}),
        }
    }
}
