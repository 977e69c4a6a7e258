//! One line per resource for terminals whose lines can be drawn again.

use ambidex_model::{ControllerId, Grant, Mode, NodeId, ResourceId};
use ambidex_record::{ActiveCommand, History, MissionOutcome, Presence};

use crate::Palette;
use crate::text::{MIN_WIDTH, clip, columns, fit, listed};

/// Columns behind a bar: `" 100 %"`.
const PERCENT: usize = 6;
/// Columns that the users of a resource have before its bar grows.
const LEAST_USERS: usize = 10;

/// The display: a head line, then one line per resource in resource order.
pub fn rows(history: &History, width: usize, palette: &Palette) -> Vec<String> {
    let width = width.max(MIN_WIDTH);
    let names = &history.names().resources;
    let longest = names.iter().map(|name| columns(name)).max();
    let name_width = longest.unwrap_or_default().min(width / 3);
    let room = width - name_width - 4;
    let bar_width = room.saturating_sub(PERCENT + 2 + LEAST_USERS);
    let bar_width = bar_width.clamp(4, (width / 4).min(30));
    let rows = names.iter().enumerate().map(|(resource, name)| {
        let row = Row { history, resource: ResourceId::from(resource), room, bar_width, palette };
        format!("  {}  {}", fit(name, name_width), row.text())
    });
    std::iter::once(head(history, width, palette)).chain(rows).collect()
}

fn head(history: &History, width: usize, palette: &Palette) -> String {
    let mission = clip(&history.header().mission, width / 3);
    let counts = history.counts(NodeId(0));
    let mut figures = format!("{} · step {} · {}/{} done", history.now(), history.step_count(), counts.done, counts.of);
    if let Some(end) = history.end() {
        figures += &format!(" · {}", MissionOutcome::from(end).word());
    }
    let rest = clip(&figures, width - columns(&mission) - 2);
    format!("{}  {rest}", Palette::paint(palette.strong, mission))
}

/// What stands behind the name of a resource.
struct Row<'a> {
    history: &'a History,
    resource: ResourceId,
    room: usize,
    bar_width: usize,
    palette: &'a Palette,
}

impl Row<'_> {
    fn text(&self) -> String {
        let Self { room, palette, .. } = *self;
        let controller = self.history.header().movers.get(self.resource.index()).copied().flatten();
        if let Some(absent) = controller.and_then(|id| self.absent(id)) {
            return absent;
        }
        let users = self.users();
        let users_room = room - self.bar_width - PERCENT - 2;
        match controller.and_then(|id| self.command(id)) {
            Some(command) if command.mode == Mode::Achieve => {
                let percent = (command.progress * 100.0).floor();
                let bar = palette.bar(command.progress, self.bar_width);
                format!("{}  {bar} {percent:>3.0} %", fit(&users, users_room))
            }
            Some(command) => format!("{}  {}", fit(&users, users_room), Palette::paint(palette.active, command.verb)),
            None if users.is_empty() => Palette::paint(palette.faint, clip(&self.idle(), room)),
            None => clip(&users, room),
        }
    }

    /// The behaviors that use it and for what.
    fn users(&self) -> String {
        let names = self.history.names();
        let uses = |(leaf, grant): (&NodeId, &Grant)| {
            let mut bindings = grant.bindings.iter().filter(|binding| binding.resource == self.resource);
            bindings.next_back().map(|binding| (*leaf, binding.access.channel()))
        };
        let users: Vec<_> = self.history.running().iter().filter_map(uses).collect();
        let channel = users.last().and_then(|(_, channel)| *channel);
        let channel = channel.map_or(String::new(), |channel| format!(" · {}", names.channel(channel)));
        listed(users.iter().map(|(leaf, _)| names.node(*leaf))) + &channel
    }

    /// What is said of a controller that is not there.
    fn absent(&self, controller: ControllerId) -> Option<String> {
        let name = self.history.names().controller(controller);
        let (style, said) = match self.history.controllers().view(controller).map(|view| view.presence) {
            Some(Presence::Attached | Presence::Configured) => return None,
            Some(Presence::Lost) => (self.palette.failed, format!("lost {name}")),
            None => (self.palette.waiting, format!("waiting for {name}")),
        };
        Some(Palette::paint(style, clip(&said, self.room)))
    }

    /// What the controller does: the latest command, and of several one that ends its goal.
    fn command(&self, controller: ControllerId) -> Option<&ActiveCommand> {
        let mut own = self.history.controllers().commands(controller).rev();
        let last = own.next()?;
        let achieve = (last.mode == Mode::Maintain).then(|| own.find(|command| command.mode == Mode::Achieve));
        Some(achieve.flatten().unwrap_or(last))
    }

    fn idle(&self) -> String {
        match self.history.world().held_by(self.resource) {
            Some(object) => format!("holds {}", self.history.names().object(object)),
            None => "free".into(),
        }
    }
}
