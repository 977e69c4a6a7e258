//! Who is let in: requests for this host, of no other origin, and of those that change something the ones with the token.
//!
//! A web page that somebody opens on this machine can send requests to loopback. It cannot choose their `Host` and
//! `Origin`, and it cannot read the token.

use std::net::SocketAddr;

use axum::http::header::{AUTHORIZATION, HOST, ORIGIN};
use axum::http::{HeaderMap, Method, Uri};

use crate::token::Token;
use ambidex_runtime::control::{Refusal, Why};

/// By which way a request came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Over the Unix socket, which no web page reaches.
    Socket,
    /// Over TCP, to this address of loopback.
    Loopback(SocketAddr),
}

/// Lets a request in.
///
/// # Errors
/// Why it is not let in.
pub fn check(way: Way, method: &Method, uri: &Uri, headers: &HeaderMap, token: &Token) -> Result<(), Refusal> {
    let is_ours = |host: &str| match way {
        Way::Socket => true,
        Way::Loopback(address) => is_host(host, address),
    };
    let mut hosts = headers.get_all(HOST).iter();
    let (host, other) = (hosts.next(), hosts.next());
    let host = host.and_then(|host| host.to_str().ok());
    let is_named = host.map_or(way == Way::Socket, is_ours) && other.is_none();
    if !is_named || !uri.authority().is_none_or(|authority| is_ours(authority.as_str())) {
        return Err(foreign("it is meant for another host", way));
    }
    let is_own = |origin: &str| match way {
        Way::Socket => false,
        Way::Loopback(address) => origin.strip_prefix("http://").is_some_and(|host| is_host(host, address)),
    };
    if !headers.get_all(ORIGIN).iter().all(|origin| origin.to_str().is_ok_and(is_own)) {
        return Err(foreign("it comes from another origin", way));
    }
    // What a page loads without asking, as a picture, has no `Origin`.
    let is_same = |site: &str| matches!(site, "same-origin" | "none");
    if !headers.get_all("sec-fetch-site").iter().all(|site| site.to_str().is_ok_and(is_same)) {
        return Err(foreign("it comes from another site", way));
    }
    let has_token = || headers.get(AUTHORIZATION).is_some_and(|header| token.is_in(header.as_bytes()));
    if changes(method) && !has_token() {
        let said = "whoever changes something must know the token of this daemon";
        let help = "send `Authorization: Bearer TOKEN`; it is in the file `token` beside the daemon's socket";
        return Err(Refusal::new(Why::Token, said).with_help(help));
    }
    Ok(())
}

/// Whether a request of this method may change something.
pub fn changes(method: &Method) -> bool {
    !matches!(*method, Method::GET | Method::HEAD | Method::OPTIONS)
}

/// Whether a host with its port is this address, as it is written or as `localhost`.
fn is_host(host: &str, address: SocketAddr) -> bool {
    let port = address.port();
    let names = [address.to_string(), format!("localhost:{port}")];
    let is_default = port == 80 && [address.ip().to_string(), "localhost".into()].iter().any(|name| name == host);
    names.iter().any(|name| name.eq_ignore_ascii_case(host)) || is_default
}

fn foreign(said: &str, way: Way) -> Refusal {
    let refusal = Refusal::new(Why::Foreign, said);
    match way {
        Way::Socket => refusal,
        Way::Loopback(address) => refusal.with_help(format!("ask http://{address} directly")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::{HeaderName, HeaderValue};

    /// What comes of a request with these headers; `token` stands for a right one.
    fn asked(way: Way, method: Method, uri: &str, headers: &[(&str, &str)]) -> Option<Why> {
        let token = Token::fresh().expect("chance");
        let header = |(name, value): &(&str, &str)| {
            let name: HeaderName = name.parse().expect("a name");
            let value = if *value == "token" { token.header() } else { (*value).to_owned() };
            (name, HeaderValue::from_str(&value).expect("a value"))
        };
        let mut all = HeaderMap::new();
        headers.iter().map(header).for_each(|(name, value)| _ = all.append(name, value));
        let uri = uri.parse().expect("a path");
        check(way, &method, &uri, &all, &token).err().map(|refusal| refusal.why)
    }

    #[test]
    fn loopback_is_asked_by_its_own_name_and_origin_alone() {
        let check = |headers: &[(&str, &str)], expected: Option<Why>| {
            let way = Way::Loopback("127.0.0.1:8080".parse().expect("an address"));
            assert_eq!(asked(way, Method::GET, "/v1/status", headers), expected, "{headers:?}");
        };
        let foreign = Some(Why::Foreign);
        check(&[("host", "127.0.0.1:8080")], None);
        check(&[("host", "LocalHost:8080")], None);
        check(&[("host", "[::1]:8080")], foreign);
        check(&[("host", "127.0.0.1")], foreign);
        check(&[("host", "127.0.0.1:80801")], foreign);
        check(&[("host", "rebound.example:8080")], foreign);
        check(&[("host", "localhost.example:8080")], foreign);
        check(&[], foreign);
        let ours = ("host", "localhost:8080");
        check(&[ours, ("host", "rebound.example")], foreign);
        check(&[ours, ("origin", "http://localhost:8080")], None);
        check(&[ours, ("origin", "http://127.0.0.1:8080")], None);
        check(&[ours, ("origin", "https://localhost:8080")], foreign);
        check(&[ours, ("origin", "http://localhost:8081")], foreign);
        check(&[ours, ("origin", "http://evil.example")], foreign);
        check(&[ours, ("origin", "null")], foreign);
        check(&[ours, ("sec-fetch-site", "same-origin")], None);
        check(&[ours, ("sec-fetch-site", "cross-site")], foreign);
        let way = Way::Loopback("127.0.0.1:8080".parse().expect("an address"));
        assert_eq!(asked(way, Method::GET, "http://rebound.example/v1/status", &[ours]), foreign);
        assert_eq!(asked(way, Method::GET, "http://localhost:8080/v1/status", &[ours]), None);
    }

    #[test]
    fn the_socket_has_any_host_and_no_origin() {
        let check = |headers: &[(&str, &str)], expected: Option<Why>| {
            assert_eq!(asked(Way::Socket, Method::GET, "/v1/status", headers), expected, "{headers:?}");
        };
        check(&[], None);
        check(&[("host", "anything")], None);
        check(&[("host", "localhost"), ("origin", "http://localhost")], Some(Why::Foreign));
    }

    #[test]
    fn what_changes_something_needs_the_token_by_either_way() {
        let ours = ("host", "127.0.0.1:8080");
        for way in [Way::Socket, Way::Loopback("127.0.0.1:8080".parse().expect("an address"))] {
            for method in [Method::POST, Method::DELETE, Method::PUT, Method::PATCH] {
                assert_eq!(asked(way, method.clone(), "/v1/stop", &[ours]), Some(Why::Token));
                let wrong = ("authorization", "Bearer 0123");
                assert_eq!(asked(way, method.clone(), "/v1/stop", &[ours, wrong]), Some(Why::Token));
                assert_eq!(asked(way, method, "/v1/stop", &[ours, ("authorization", "token")]), None);
            }
        }
    }
}
