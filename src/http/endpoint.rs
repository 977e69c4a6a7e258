//! Where a daemon is asked: its socket, its address if it has one, and the files that tell of them.

use std::fs::{self, Permissions};
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};

use crate::token::{Token, write_private};
use ambidex_link::IpcNode;

/// Why a daemon cannot be asked.
#[derive(Debug, thiserror::Error)]
pub enum EndpointError {
    /// The socket or a file beside it.
    #[error("cannot make {path}")]
    File {
        /// Its path.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The address of loopback.
    #[error("cannot be asked at {address}")]
    Address {
        /// The address.
        address: SocketAddr,
        /// What the operating system says.
        source: io::Error,
    },
}

/// The socket of a daemon and what belongs to it, there until this is dropped.
#[derive(Debug)]
pub struct Endpoint {
    pub(crate) listener: UnixListener,
    pub(crate) loopback: Option<(TcpListener, SocketAddr)>,
    pub(crate) token: Token,
    files: Vec<PathBuf>,
    /// As long as it is held no other daemon takes the place, whose socket would be removed.
    _node: IpcNode,
}

impl Endpoint {
    /// Makes the socket of the instance in which the node is the daemon's, in the place of one that a killed daemon left;
    /// and listens at an address of loopback, if one is given.
    ///
    /// # Errors
    /// [`EndpointError`] when one of them cannot be had.
    pub fn open(node: &IpcNode, address: Option<SocketAddr>) -> Result<Self, EndpointError> {
        let instance = node.instance();
        let (token_file, address_file) = (instance.token_file(), instance.address_file());
        let file = |path: &Path, source| EndpointError::File { path: path.to_owned(), source };
        let token = Token::fresh().and_then(|token| token.write(&token_file).map(|()| token));
        let token = token.map_err(|source| file(&token_file, source))?;
        let mut files = vec![token_file];
        let loopback = address.map(listen).transpose()?;
        // One that a killed daemon left tells of nobody.
        match (&loopback, fs::remove_file(&address_file)) {
            (_, Err(source)) if source.kind() != io::ErrorKind::NotFound => return Err(file(&address_file, source)),
            (None, _) => {}
            (Some((_, address)), _) => {
                write_private(&address_file, &address.to_string()).map_err(|source| file(&address_file, source))?;
                files.push(address_file);
            }
        }
        let path = instance.control_socket();
        let listener = bind(&path).map_err(|source| file(&path, source))?;
        files.push(path);
        Ok(Self { listener, loopback, token, files, _node: node.clone() })
    }

    /// Where it is asked over TCP, if it is.
    pub fn address(&self) -> Option<SocketAddr> {
        self.loopback.as_ref().map(|(_, address)| *address)
    }
}

impl Drop for Endpoint {
    fn drop(&mut self) {
        // A folder that was removed has taken them along.
        self.files.iter().for_each(|path| drop(fs::remove_file(path)));
    }
}

fn listen(address: SocketAddr) -> Result<(TcpListener, SocketAddr), EndpointError> {
    let listen = || {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let bound = listener.local_addr()?;
        Ok((listener, bound))
    };
    listen().map_err(|source| EndpointError::Address { address, source })
}

/// The socket gets its name once nobody else can open it.
fn bind(path: &Path) -> io::Result<UnixListener> {
    let made = path.with_extension("new");
    match fs::remove_file(&made) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        Ok(()) | Err(_) => {}
    }
    let listener = UnixListener::bind(&made)?;
    listener.set_nonblocking(true)?;
    fs::set_permissions(&made, Permissions::from_mode(0o600))?;
    fs::rename(&made, path)?;
    Ok(listener)
}
