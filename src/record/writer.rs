//! Records out: one JSON line each, in the order in which they are given. Nothing is added to them.

use std::io::{self, Write};

use ambidex_model::Record;

/// A journal on anything that takes bytes.
#[derive(Debug)]
pub struct Journal<W: Write> {
    out: W,
    line: Vec<u8>,
    lines: u64,
    bytes: u64,
}

impl<W: Write> Journal<W> {
    /// A journal that has no lines yet.
    pub fn new(out: W) -> Self {
        Self { out, line: Vec::new(), lines: 0, bytes: 0 }
    }

    /// Writes one record as one line.
    ///
    /// # Errors
    /// When the bytes are not taken; the journal then ends within a line.
    pub fn write(&mut self, record: &Record) -> io::Result<()> {
        self.line.clear();
        serde_json::to_writer(&mut self.line, record)?;
        self.line.push(b'\n');
        self.out.write_all(&self.line)?;
        self.lines += 1;
        self.bytes += self.line.len() as u64;
        Ok(())
    }

    /// Hands on all that is buffered.
    ///
    /// # Errors
    /// When the bytes are not taken.
    pub fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }

    /// Lines written so far.
    pub fn lines(&self) -> u64 {
        self.lines
    }

    /// Bytes written so far.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// What is written to.
    pub fn get_ref(&self) -> &W {
        &self.out
    }

    /// What is written to, to be changed.
    pub fn get_mut(&mut self) -> &mut W {
        &mut self.out
    }

    /// What was written to.
    pub fn into_inner(self) -> W {
        self.out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;

    #[test]
    fn every_record_is_one_line() {
        let mut journal = Journal::new(Vec::new());
        let records = samples::records();
        for record in &records {
            journal.write(record).unwrap();
        }
        assert_eq!(journal.lines(), records.len() as u64);
        let text = String::from_utf8(journal.into_inner()).unwrap();
        assert_eq!(text.lines().count(), records.len());
        assert!(text.ends_with('\n'));
    }

    #[test]
    fn a_line_reads_as_said() {
        let mut journal = Journal::new(Vec::new());
        journal.write(&samples::activation()).unwrap();
        assert_eq!(
            String::from_utf8(journal.into_inner()).unwrap(),
            "{\"record\":\"sent\",\"at\":1500000,\"round\":3,\"from\":0,\"to\":1,\
             \"message\":{\"kind\":\"activation\"}}\n"
        );
    }
}
