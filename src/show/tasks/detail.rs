//! A task with its tree.

use ambidex_model::NodeId;
use ambidex_record::History;
use serde::{Deserialize, Serialize};

use super::summary::{TaskSummary, summaries};
use crate::status::{NodeRow, node_rows};

/// A task with its tree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct TaskDetail {
    /// How far it is.
    #[serde(flatten)]
    pub summary: TaskSummary,
    /// Every node of it in tree order.
    pub nodes: Vec<NodeRow>,
}

/// The task of that number with its tree; none where there is no such task.
pub fn detail(history: &History, task: u32) -> Option<TaskDetail> {
    let summary = summaries(history).into_iter().find(|summary| summary.task == task)?;
    let top = NodeId(task);
    let nodes = node_rows(history).into_iter().filter(|row| history.is_within(NodeId(row.id), top));
    let nodes = nodes.map(|row| NodeRow { parent: row.parent.filter(|_| row.id != task), ..row });
    Some(TaskDetail { summary, nodes: nodes.collect() })
}
