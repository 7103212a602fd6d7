//! One page as a file holds it: channels by their names, whether ambake or somebody else wrote them.

/// All layers of one page file. Pages are square; row 0 is the top and v = 0.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Page {
    /// Edge in texels.
    pub size: u32,
    /// Layers in any order; names are unique.
    pub layers: Vec<PageLayer>,
}

/// The channels of a page that share a name but for their suffix.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PageLayer {
    /// Name as in the file contract, such as `diffuse` or `difference.lambert`.
    pub name: String,
    /// One channel with an empty suffix, or several.
    pub channels: Vec<Channel>,
}

/// One float for every texel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Channel {
    /// Empty, or `R`, `G`, `B`, `X`, `Y`, `Z`.
    pub suffix: String,
    /// `size * size` values, rows from the top.
    pub values: Vec<f32>,
}

impl Page {
    /// The layer called `name`.
    pub fn layer(&self, name: &str) -> Option<&PageLayer> {
        self.layers.iter().find(|layer| layer.name == name)
    }

    /// The values of a single-channel layer.
    pub fn values(&self, name: &str) -> Option<&[f32]> {
        match self.layer(name)?.channels.as_slice() {
            [one] => Some(&one.values),
            _ => None,
        }
    }

    /// Every channel under its name in a file, with its values, in the order of `layers`.
    pub fn named_channels(&self) -> Vec<(String, &[f32])> {
        let channels = self
            .layers
            .iter()
            .flat_map(|layer| layer.channels.iter().map(move |c| (layer, c)));
        channels
            .map(|(layer, channel)| (layer.channel_name(channel), channel.values.as_slice()))
            .collect()
    }
}

impl PageLayer {
    /// A layer of one channel.
    pub fn scalar(name: &str, values: Vec<f32>) -> PageLayer {
        PageLayer {
            name: name.into(),
            channels: vec![Channel {
                suffix: String::new(),
                values,
            }],
        }
    }

    /// A layer of three channels with the suffixes R, G, B or X, Y, Z.
    pub fn triple(name: &str, suffixes: [&str; 3], values: [Vec<f32>; 3]) -> PageLayer {
        let channels = suffixes.into_iter().zip(values);
        let channels = channels
            .map(|(suffix, values)| Channel {
                suffix: suffix.into(),
                values,
            })
            .collect();
        PageLayer {
            name: name.into(),
            channels,
        }
    }

    /// The name of one of its channels in a file.
    pub fn channel_name(&self, channel: &Channel) -> String {
        if channel.suffix.is_empty() {
            self.name.clone()
        } else {
            format!("{}.{}", self.name, channel.suffix)
        }
    }
}
