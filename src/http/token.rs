//! The word that whoever changes something must know. It lies in a file that only the daemon's user can read, so that
//! who has it is that user.

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use rustix::rand::{GetRandomFlags, getrandom};
use subtle::ConstantTimeEq;

/// Bytes of chance.
const LENGTH: usize = 32;

/// A token.
#[derive(Clone)]
pub struct Token(String);

impl Token {
    /// A new one, which nobody can guess.
    ///
    /// # Errors
    /// When the system has no chance to give.
    pub fn fresh() -> io::Result<Self> {
        let mut bytes = [0_u8; LENGTH];
        let mut filled = 0;
        while filled < LENGTH {
            filled += getrandom(&mut bytes[filled..], GetRandomFlags::empty())?;
        }
        Ok(Self(bytes.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    /// Writes it where only this user can read it, in the place of an older one.
    ///
    /// # Errors
    /// When the file cannot be made.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        write_private(path, &self.0)
    }

    /// Reads it.
    ///
    /// # Errors
    /// When there is none that can be read.
    pub fn read(path: &Path) -> io::Result<Self> {
        fs::read_to_string(path).map(|text| Self(text.trim().to_owned()))
    }

    /// The value of the header `Authorization`.
    pub fn header(&self) -> String {
        format!("Bearer {}", self.0)
    }

    /// Whether the value of a header `Authorization` has it, in a time that tells nothing of it.
    pub fn is_in(&self, header: &[u8]) -> bool {
        let Some((scheme, token)) = header.split_at_checked("Bearer ".len()) else { return false };
        scheme.eq_ignore_ascii_case(b"Bearer ") && bool::from(self.0.as_bytes().ct_eq(token.trim_ascii()))
    }
}

/// Nothing prints it.
impl std::fmt::Debug for Token {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str("Token")
    }
}

/// Writes a file of mode 0600; it has its name only once it is whole.
///
/// # Errors
/// When it cannot be made.
pub fn write_private(path: &Path, text: &str) -> io::Result<()> {
    let made = path.with_extension("new");
    match fs::remove_file(&made) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        Ok(()) | Err(_) => {}
    }
    let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&made)?;
    writeln!(file, "{text}")?;
    fs::rename(&made, path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn it_is_read_as_it_was_written_by_its_user_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("token");
        for _ in 0..2 {
            let token = Token::fresh().expect("chance");
            token.write(&path).expect("a file");
            assert_eq!(fs::metadata(&path).expect("it is there").permissions().mode() & 0o777, 0o600);
            assert_eq!(Token::read(&path).expect("it is there").header(), token.header());
        }
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
        assert_ne!(Token::fresh().expect("chance").0, Token::fresh().expect("chance").0);
    }

    #[test]
    fn only_the_whole_token_counts() {
        let token = Token("0123456789abcdef".into());
        let check = |header: &str, expected: bool| assert_eq!(token.is_in(header.as_bytes()), expected, "{header}");
        check("Bearer 0123456789abcdef", true);
        check("bearer  0123456789abcdef", true);
        check("Bearer 0123456789abcde", false);
        check("Bearer 0123456789abcdef0", false);
        check("Bearer 0123456789ABCDEF", false);
        check("Basic 0123456789abcdef", false);
        check("0123456789abcdef", false);
        check("Bearer ", false);
        check("", false);
        assert_eq!(format!("{token:?}"), "Token");
    }
}
