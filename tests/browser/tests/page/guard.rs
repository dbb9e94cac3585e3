//! Who may ask, and how much.

use std::io::{Read, Write};
use std::net::TcpStream;

use motorlens_browser_tests::Server;

/// The first line of the answer to a request with these lines and this much of a body.
fn answer(server: &Server, lines: &[&str], body: usize) -> String {
    let address = server.url.strip_prefix("http://").expect("plain HTTP");
    assert!(address.starts_with("127.0.0.1:"), "{address} is not this machine alone");
    let mut stream = TcpStream::connect(address).unwrap();
    let request = lines.join("\r\n").replace("SELF", address) + "\r\nConnection: close\r\n\r\n";
    stream.write_all(request.as_bytes()).unwrap();
    let chunk = vec![b'0'; 1 << 20];
    for _ in 0..body.div_ceil(chunk.len()) {
        // The server may hang up once it has seen enough.
        if stream.write_all(&chunk).is_err() {
            break;
        }
    }
    let mut text = Vec::new();
    let _ = stream.read_to_end(&mut text);
    String::from_utf8_lossy(&text).lines().next().unwrap_or_default().to_owned()
}

#[test]
fn only_the_own_page_is_answered_and_uploads_have_a_limit() {
    let server = Server::start::<&str>(&[]);
    assert!(answer(&server, &["GET / HTTP/1.1", "Host: SELF"], 0).contains("200"));
    assert!(answer(&server, &["GET / HTTP/1.1", "Host: evil.example"], 0).contains("403"));
    let post = "POST /api/diagnose HTTP/1.1";
    assert!(answer(&server, &[post, "Host: SELF", "Origin: http://evil.example"], 0).contains("403"));
    let upload = "POST /api/upload?name=a.csv&role=fit HTTP/1.1";
    let large = 201_000_000;
    let length = format!("Content-Length: {large}");
    let refused = answer(&server, &[upload, "Host: SELF", &length], large);
    assert!(refused.contains("413"), "{refused}");
}
