//! A stand-in for a lane that listens to aiding measurements.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{sleep, spawn};
use std::time::Duration;

use lodestone_client::{Aiding, Client};
use lodestone_schema::ServiceKind;
use lodestone_schema::transport::{Qos, open_for_writing};

use super::TestDomain;

/// Collects what is offered to a camera's lane; its thread ends after this value.
pub(crate) struct Listener {
    offered: Receiver<Aiding>,
}

/// Listens from now on.
pub(crate) fn start(domain: &TestDomain, camera: &'static str) -> Listener {
    let client = domain.client();
    let (heard, offered) = channel();
    let (is_ready, ready) = channel();
    spawn(move || listen(&client, camera, &is_ready, &heard));
    ready.recv().expect("listens");
    Listener { offered }
}

/// Ports stay on their thread, and hear a publisher only while they look for it.
fn listen(client: &Client, camera: &str, is_ready: &Sender<()>, heard: &Sender<Aiding>) {
    let node = client.domain().open_node("lane").expect("a node");
    let qos = Qos { history: 0, max_subscribers: 2, max_publishers: 4, max_borrowed: 2 };
    let service = open_for_writing::<Aiding>(&node, ServiceKind::Aiding, camera, qos);
    let service = service.expect("a service");
    let port = service.subscriber_builder().create().expect("a port");
    is_ready.send(()).expect("is waited for");
    loop {
        while let Some(aiding) = port.receive().expect("receives") {
            if heard.send(*aiding).is_err() {
                return;
            }
        }
        sleep(Duration::from_millis(10));
    }
}

impl Listener {
    /// The last measurement that came.
    pub(crate) fn last(&self) -> Aiding {
        self.offered.try_iter().last().expect("a measurement")
    }
}
