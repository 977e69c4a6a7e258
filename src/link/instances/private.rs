//! Files and folders that are for this user alone.

use std::fs::{self, DirBuilder, File, OpenOptions, Permissions};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;

use super::paths::segments;
use crate::error::IpcError;

const FOLDER: u32 = 0o700;
const FILE: u32 = 0o600;
/// What group and others may do.
const OTHERS: u32 = 0o077;

/// Makes a folder that nobody else can look into, or sees to it that the one which is there is such a folder.
///
/// # Errors
/// [`IpcError::Foreign`] when it belongs to another user or is no folder, [`IpcError::File`] when it cannot be made.
pub(crate) fn folder(path: &Path) -> Result<(), IpcError> {
    match DirBuilder::new().mode(FOLDER).create(path) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(IpcError::file(path)(error)),
        Ok(()) | Err(_) => {}
    }
    // The link itself is looked at, not what it leads to: another user may have laid it.
    let about = fs::symlink_metadata(path).map_err(IpcError::file(path))?;
    if !about.is_dir() || about.uid() != rustix::process::getuid().as_raw() {
        return Err(IpcError::Foreign { path: path.to_owned(), uid: about.uid() });
    }
    // The mode may be too narrow as well: the transport changes the umask of the process while it binds a socket.
    if about.mode() & (FOLDER | OTHERS) != FOLDER {
        fs::set_permissions(path, Permissions::from_mode(FOLDER)).map_err(IpcError::file(path))?;
    }
    Ok(())
}

/// Opens a file that nobody else can open, as the options say; made if they say so.
pub(crate) fn open(options: &mut OpenOptions, path: &Path) -> io::Result<File> {
    options.mode(FILE).open(path)
}

/// The transport lets everybody write to some of its segments: takes that back.
pub(crate) fn restrict(prefix: &str) {
    for path in segments(prefix) {
        if fs::symlink_metadata(&path).is_ok_and(|about| about.is_file() && about.mode() & OTHERS != 0)
            && let Err(error) = fs::set_permissions(&path, Permissions::from_mode(FILE))
        {
            tracing::warn!(path = %path.display(), %error, "others may open this segment");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(path: &Path) -> u32 {
        fs::symlink_metadata(path).unwrap().mode() & 0o777
    }

    #[test]
    fn what_is_made_is_for_this_user_alone() {
        let base = std::env::temp_dir().join(format!("ambidex-private-{}", std::process::id()));
        folder(&base).unwrap();
        assert_eq!(mode(&base), 0o700);
        for (found, is) in [(0o755, "wider"), (0o600, "narrower")] {
            fs::set_permissions(&base, Permissions::from_mode(found)).unwrap();
            folder(&base).unwrap();
            assert_eq!(mode(&base), 0o700, "one that was made {is} before");
        }
        let file = base.join("lock");
        open(File::options().create(true).append(true), &file).unwrap();
        assert_eq!(mode(&file), 0o600);
        // Neither a file nor a link is a folder, whatever it leads to.
        let link = base.join("link");
        std::os::unix::fs::symlink(&base, &link).unwrap();
        for no_folder in [&file, &link] {
            let refused = folder(no_folder).unwrap_err();
            assert!(matches!(refused, IpcError::Foreign { .. }), "{refused}");
        }
        fs::remove_dir_all(&base).unwrap();
    }
}
