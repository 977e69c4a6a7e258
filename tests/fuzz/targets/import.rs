//! Files of the dHTT software.

use std::path::Path;

use ambidex::files::{Fault, ImportError, Imported, InMemory, import as import_file};

use super::Taken;

const TASK: &str = "\
NodeList: [TOP, CUT]
Nodes:
  TOP: {type: 1, behavior_type: 'a::AndBehavior', robot: 0, parent: 'NONE', params: []}
  CUT: {type: 4, behavior_type: 'a::TestBehavior', robot: 0, parent: TOP, params: ['activation_potential: 4.0']}
";

/// As a task or a robot, and as the robot for a task.
pub fn import(text: &[u8]) -> Taken {
    let mut files = InMemory::default();
    files.insert("input.yaml", text.to_vec());
    files.insert("task.yaml", TASK);
    let input = Path::new("input.yaml");
    let mut taken = told(import_file(&files, input, None, None));
    let for_task = told(import_file(&files, "task.yaml".as_ref(), Some(input), Some("out/made.yaml".as_ref())));
    taken.kinds.extend(for_task.kinds);
    taken.accepted |= for_task.accepted;
    taken
}

fn told(imported: Result<Imported, ImportError>) -> Taken {
    let mut taken = Taken { accepted: imported.is_ok(), ..Taken::default() };
    let mut say = |faults: &[Fault]| faults.iter().for_each(|fault| taken.said(fault.message()));
    match &imported {
        Ok(imported) => say(&imported.warnings),
        Err(ImportError::Faulty(error)) => say(error.faults()),
        Err(error @ ImportError::TooLarge(_)) => taken.said(&error.to_string()),
        // What was taken without a complaint has to be a mission.
        Err(ImportError::Defect(error)) => {
            panic!("what was made of it does not load\n{:?}", error.faults().first().map(Fault::message))
        }
    }
    taken
}
