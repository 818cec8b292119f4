//! A map of one road.

/// A straight road of 700 m to the east with these types and signals.
pub fn map(types: &str, signals: &str) -> String {
    let lane = |id: i32| format!(r#"<lane id="{id}" type="driving"><width a="3.5"/></lane>"#);
    let (left, right) = (lane(1), lane(-1));
    format!(
        r#"<OpenDRIVE><road id="1" length="700" junction="-1">{types}<planView><geometry s="0" x="0" y="0" hdg="0" length="700"><line/></geometry></planView><lanes><laneSection s="0"><left>{left}</left><right>{right}</right></laneSection></lanes><signals>{signals}</signals></road></OpenDRIVE>"#
    )
}
