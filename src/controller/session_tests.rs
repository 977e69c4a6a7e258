//! The session alone, with time handed in.

use super::*;
