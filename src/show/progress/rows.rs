//! One line per resource for terminals whose lines can be drawn again.

use crate::Palette;
use crate::crew::{Presence, UnderWay};
use crate::text::{MIN_WIDTH, clip, columns, fit};
use ambidex_model::{ControllerId, MissionEnd, Mode, Names, NodeId, ResourceId};

use super::Progress;

/// Columns behind a bar: `" 100 %"`.
const PERCENT: usize = 6;
/// Columns that the users of a resource have before its bar grows.
const LEAST_USERS: usize = 10;

impl Progress {
    /// The display: a head line, then one line per resource in resource order.
    pub fn lines(&self, width: usize, palette: &Palette) -> Vec<String> {
        let width = width.max(MIN_WIDTH);
        let mut lines = vec![self.head(width, palette)];
        let Some(header) = &self.tally.header else {
            return lines;
        };
        let names = &header.names;
        let longest = names.resources.iter().map(|name| columns(name)).max();
        let name_width = longest.unwrap_or_default().min(width / 3);
        let room = width - name_width - 4;
        let bar_width = room.saturating_sub(PERCENT + 2 + LEAST_USERS);
        let bar_width = bar_width.clamp(4, (width / 4).min(30));
        let using = self.using(names);
        for (resource, name) in names.resources.iter().enumerate() {
            let resource = ResourceId::from(resource);
            let name = fit(name, name_width);
            let users = using.get(resource.index()).map_or("", String::as_str);
            let row = self.row(resource, users, room, bar_width, palette);
            lines.push(format!("  {name}  {row}"));
        }
        lines
    }

    fn head(&self, width: usize, palette: &Palette) -> String {
        let tally = &self.tally;
        let Some(header) = &tally.header else {
            return clip("no mission yet", width);
        };
        let mission = clip(&header.mission, width / 3);
        let figures = format!("{} · step {} · {}/{} done", tally.now, tally.steps.len(), self.done(), self.behaviors);
        let ended = match tally.end {
            None => "",
            Some(MissionEnd::Done) => " · done",
            Some(MissionEnd::Stalled) => " · stalled",
            Some(MissionEnd::Canceled) => " · cancelled",
            Some(
                MissionEnd::Failed(_)
                | MissionEnd::ControllerLost(_)
                | MissionEnd::NotAttached
                | MissionEnd::NodeLost(_)
                | MissionEnd::TaskLost,
            ) => " · failed",
        };
        let rest = clip(&(figures + ended), width - columns(&mission) - 2);
        format!("{}  {rest}", Palette::paint(palette.strong, mission))
    }

    /// By resource: the behaviors that use it and for what.
    fn using(&self, names: &Names) -> Vec<String> {
        let mut users: Vec<(Vec<NodeId>, Option<&str>)> = vec![(Vec::new(), None); names.resources.len()];
        for (&leaf, bindings) in &self.running {
            for binding in bindings {
                let Some((leaves, channel)) = users.get_mut(binding.resource.index()) else {
                    continue;
                };
                if leaves.last() != Some(&leaf) {
                    leaves.push(leaf);
                }
                *channel = binding.access.channel().map(|channel| names.channel(channel));
            }
        }
        let text = |(leaves, channel): (Vec<NodeId>, Option<&str>)| {
            let leaves: Vec<&str> = leaves.iter().map(|&leaf| names.node(leaf)).collect();
            let channel = channel.map_or(String::new(), |channel| format!(" · {channel}"));
            leaves.join(" + ") + &channel
        };
        users.into_iter().map(text).collect()
    }

    /// What stands behind the name of a resource.
    fn row(&self, resource: ResourceId, users: &str, room: usize, bar_width: usize, palette: &Palette) -> String {
        let controller = self.movers.get(resource.index()).copied().flatten();
        if let Some(absent) = controller.and_then(|id| self.absent(id, room, palette)) {
            return absent;
        }
        let command = controller.and_then(|id| self.command(id));
        match command {
            Some(command) if command.mode == Mode::Achieve => {
                let users = fit(users, room - bar_width - PERCENT - 2);
                let percent = (command.progress * 100.0).floor();
                let bar = palette.bar(command.progress, bar_width);
                format!("{users}  {bar} {percent:>3.0} %")
            }
            Some(command) => {
                let users = fit(users, room - bar_width - PERCENT - 2);
                let verb = Palette::paint(palette.active, command.verb);
                format!("{users}  {verb}")
            }
            None if users.is_empty() => Palette::paint(palette.faint, self.idle(resource, room)),
            None => clip(users, room),
        }
    }

    /// What is said of a controller that is not there.
    fn absent(&self, controller: ControllerId, room: usize, palette: &Palette) -> Option<String> {
        let names = &self.tally.header.as_ref()?.names;
        let name = names.controller(controller);
        match self.crew.member(controller).map(|member| member.presence) {
            Some(Presence::Attached | Presence::Configured) => None,
            Some(Presence::Lost) => {
                let text = clip(&format!("lost {name}"), room);
                Some(Palette::paint(palette.failed, text))
            }
            None => {
                let text = clip(&format!("waiting for {name}"), room);
                Some(Palette::paint(palette.waiting, text))
            }
        }
    }

    /// What the controller does: the latest command, and of several one that ends its goal.
    fn command(&self, controller: ControllerId) -> Option<&UnderWay> {
        let mut own = self.crew.commands(controller).rev();
        let last = own.next()?;
        let achieve = (last.mode == Mode::Maintain).then(|| own.find(|command| command.mode == Mode::Achieve));
        Some(achieve.flatten().unwrap_or(last))
    }

    fn idle(&self, resource: ResourceId, room: usize) -> String {
        let names = self.tally.header.as_ref().map(|header| &header.names);
        match (self.holding.get(&resource), names) {
            (Some(&object), Some(names)) => clip(&format!("holds {}", names.object(object)), room),
            (Some(_), None) | (None, _) => "free".into(),
        }
    }
}
