//! Fitting a snapshot into the lines of a terminal: what matters most stays, and it is told what is left out.

use super::outline::Outline;

/// Lines that the tree has at least, its head included, before other parts are cut.
const LEAST_TREE: usize = 5;

/// A line of a table; of a table that is cut the greatest ranks go first.
#[derive(Debug, Clone)]
pub(super) struct Row {
    pub(super) rank: u8,
    pub(super) text: String,
}

/// The parts of a page; the tree comes last, so that the others stay where they are while it changes.
#[derive(Debug)]
pub(super) struct Page<'a> {
    pub(super) head: Vec<String>,
    pub(super) resources: Vec<Row>,
    pub(super) controllers: Vec<Row>,
    pub(super) world: Vec<String>,
    pub(super) outline: Outline<'a>,
}

impl Page<'_> {
    /// At most so many lines.
    pub(super) fn lines(mut self, height: usize) -> Vec<String> {
        let least_tree = LEAST_TREE.min(self.outline.height());
        if self.fixed() + least_tree > height {
            self.world.truncate(1);
            let room = height.saturating_sub(self.head.len() + self.world.len() + least_tree);
            let for_controllers = (room / 2).max(room.saturating_sub(self.resources.len()));
            self.controllers = cut(self.controllers, for_controllers);
            self.resources = cut(self.resources, room.saturating_sub(self.controllers.len()));
        }
        let left = height.saturating_sub(self.fixed());
        let tree = self.outline.lines(left);
        let blanks = left.saturating_sub(tree.len());
        let text = |rows: Vec<Row>| rows.into_iter().map(|row| row.text).collect();
        // With few lines to spare the tree is set apart first, the world last.
        let parts: [(usize, Vec<String>); 4] =
            [(2, text(self.resources)), (3, text(self.controllers)), (4, self.world), (1, tree)];
        let mut lines = self.head;
        for (rank, part) in parts {
            if rank <= blanks {
                lines.push(String::new());
            }
            lines.extend(part);
        }
        lines.truncate(height);
        lines
    }

    fn fixed(&self) -> usize {
        self.head.len() + self.resources.len() + self.controllers.len() + self.world.len()
    }
}

/// The head, the rows that matter most, and how many more there are.
fn cut(rows: Vec<Row>, room: usize) -> Vec<Row> {
    if rows.len() <= room {
        return rows;
    }
    let mut order: Vec<usize> = (1..rows.len()).collect();
    order.sort_by_key(|&index| (rows[index].rank, index));
    order.truncate(room.saturating_sub(2));
    order.push(0);
    let more = rows.len() - order.len();
    let kept = rows.into_iter().enumerate().filter(|(index, _)| order.contains(index)).map(|(_, row)| row);
    let note = Row { rank: u8::MAX, text: format!("… {more} more") };
    kept.chain([note]).take(room).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_cut_table_what_matters_stays() {
        let rows = |ranks: &[u8]| -> Vec<Row> {
            ranks.iter().enumerate().map(|(index, &rank)| Row { rank, text: index.to_string() }).collect()
        };
        let check = |ranks: &[u8], room: usize, expected: &str| {
            let texts: Vec<String> = cut(rows(ranks), room).into_iter().map(|row| row.text).collect();
            assert_eq!(texts.join(" "), expected);
        };
        check(&[0, 1, 1], 3, "0 1 2");
        check(&[0, 1, 1, 0, 1], 4, "0 1 3 … 2 more");
        check(&[0, 1, 1, 0, 1], 2, "0 … 4 more");
        check(&[0, 1], 0, "");
    }
}
