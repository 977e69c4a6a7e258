//! One connection, whatever carries it.

use std::pin::Pin;

use axum::Router;
use hyper::server::conn::http1::{Builder, Connection};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio_io_timeout::TimeoutStream;

use crate::gate::Way;
use crate::limits::{HEAD_MAX, HEAD_WITHIN, HEADERS_MAX, TAKEN_WITHIN};
use crate::routes::Served;

/// A stream that breaks when nobody takes what is written.
type Impatient<I> = TokioIo<Pin<Box<TimeoutStream<I>>>>;

/// A connection that is being answered.
pub type Answering<I> = Connection<Impatient<I>, TowerToHyperService<Router>>;

/// Answers what comes over a stream, until the other side leaves or asks nothing for too long.
pub fn answering<I>(router: Router, stream: I) -> Answering<I>
where
    I: AsyncRead + AsyncWrite + Send + 'static,
{
    let mut stream = TimeoutStream::new(stream);
    stream.set_write_timeout(Some(TAKEN_WITHIN));
    let mut http = Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD_WITHIN).max_headers(HEADERS_MAX).max_buf_size(HEAD_MAX);
    http.serve_connection(TokioIo::new(Box::pin(stream)), TowerToHyperService::new(router))
}

/// Answers what comes over a stream that is no socket, as in a test.
pub async fn answer<I>(served: Served, way: Way, stream: I)
where
    I: AsyncRead + AsyncWrite + Send + 'static,
{
    // How it ended is for whoever asked.
    let _ = answering(served.router(way), stream).await;
}
