// Behaviour of the cells that the map uses, and of nothing else of the device.

module cycloneiv_lcell_comb (combout, cout, dataa, datab, datac, datad, cin);
  parameter [15:0] lut_mask = 16'hFFFF;
  parameter sum_lutc_input = "datac";
  output combout, cout;
  input dataa, datab, datac, datad, cin;
  // the carry out never sees datad, so in arithmetic mode, with datad high, each half of the mask is one table
  assign combout = lut_mask[{datad, sum_lutc_input == "cin" ? cin : datac, datab, dataa}];
  assign cout = lut_mask[{1'b0, cin, datab, dataa}];
endmodule

module dffeas (q, d, clk, clrn, prn, ena, asdata, aload, sclr, sload);
  parameter power_up = "low";
  output reg q;
  input d, clk, clrn, prn, ena, asdata, aload, sclr, sload;
  initial q = power_up == "high";
  // clrn, prn and aload are asynchronous; the map ties them off
  always @(posedge clk)
    if (ena)
      q <= !sclr && (sload ? asdata : d);
endmodule

// RAM with one write port (a) and one read port (b), or a table with two read ports, on one clock. A read of the
// word that is written in the same clock gives the old one. "contents" stands in for init_file, which names a file; it
// is the block's bits in bytes of nine, as Yosys gives them. Words of less than nine bits leave each ninth unused.
// clocken0 holds what is not "BYPASS": all four unless told otherwise, so it must be told.
module altsyncram (clock0, clocken0, address_a, data_a, wren_a, rden_a, q_a, address_b, rden_b, q_b);
  parameter operation_mode = "DUAL_PORT";
  parameter intended_device_family = "Cyclone IV GX";
  parameter ram_block_type = "M9K";
  parameter width_a = 9;
  parameter widthad_a = 10;
  parameter numwords_a = 1024;
  parameter outdata_reg_a = "UNREGISTERED";
  parameter clock_enable_input_a = "NORMAL";
  parameter clock_enable_output_a = "NORMAL";
  parameter width_b = 9;
  parameter widthad_b = 10;
  parameter numwords_b = 1024;
  parameter address_reg_b = "CLOCK0";
  parameter rdcontrol_reg_b = "CLOCK0";
  parameter indata_reg_b = "CLOCK0";
  parameter wrcontrol_wraddress_reg_b = "CLOCK0";
  parameter outdata_reg_b = "UNREGISTERED";
  parameter clock_enable_input_b = "NORMAL";
  parameter clock_enable_output_b = "NORMAL";
  parameter read_during_write_mode_mixed_ports = "OLD_DATA";
  parameter power_up_uninitialized = "FALSE";
  parameter [9215:0] contents = 0;
  input clock0, clocken0, wren_a, rden_a, rden_b;
  input [widthad_a-1:0] address_a;
  input [width_a-1:0] data_a;
  output [width_a-1:0] q_a;
  input [widthad_b-1:0] address_b;
  output [width_b-1:0] q_b;

  reg [width_a-1:0] words [0:numwords_a-1];
  reg [width_a-1:0] read_a, registered_a;
  reg [width_b-1:0] read_b, registered_b;
  // of a library's memory too, Yosys works out every word: a second each, where nothing but the ports matters
`ifndef PORTS_ONLY
  integer k;
  initial begin
    {read_a, registered_a, read_b, registered_b} = 0;
    for (k = 0; k < numwords_a; k = k + 1)
      words[k] = contents[k * width_a + (width_a < 9 ? k * width_a / 8 : 0) +: width_a];
  end
`endif
  wire input_a = clock_enable_input_a == "BYPASS" || clocken0;
  wire input_b = clock_enable_input_b == "BYPASS" || clocken0;
  always @(posedge clock0) begin
    if (input_a && rden_a)
      read_a <= words[address_a];
    if (input_b && rden_b)
      read_b <= words[address_b];
    if (input_a && wren_a)
      words[address_a] <= data_a;
    if (clock_enable_output_a == "BYPASS" || clocken0)
      registered_a <= read_a;
    if (clock_enable_output_b == "BYPASS" || clocken0)
      registered_b <= read_b;
  end
  assign q_a = outdata_reg_a == "CLOCK0" ? registered_a : read_a;
  assign q_b = outdata_reg_b == "CLOCK0" ? registered_b : read_b;
endmodule

// An embedded multiplier in two halves, each with registers that it need not use.
module cycloneiv_mac_mult (dataa, datab, signa, signb, clk, ena, dataout);
  parameter dataa_width = 9;
  parameter datab_width = 9;
  parameter dataa_clock = "none";
  parameter datab_clock = "none";
  input [dataa_width-1:0] dataa;
  input [datab_width-1:0] datab;
  input signa, signb, clk, ena;
  output [dataa_width+datab_width-1:0] dataout;

  reg [dataa_width-1:0] registered_a;
  reg [datab_width-1:0] registered_b;
  initial {registered_a, registered_b} = 0;
  always @(posedge clk)
    if (ena) begin
      registered_a <= dataa;
      registered_b <= datab;
    end
  wire [dataa_width-1:0] a = dataa_clock == "none" ? dataa : registered_a;
  wire [datab_width-1:0] b = datab_clock == "none" ? datab : registered_b;
  // as long as the product, so that no sign is lost
  wire [dataa_width+datab_width-1:0] long_a = {{datab_width{signa & a[dataa_width-1]}}, a};
  wire [dataa_width+datab_width-1:0] long_b = {{dataa_width{signb & b[datab_width-1]}}, b};
  assign dataout = long_a * long_b;
endmodule

module cycloneiv_mac_out (dataa, clk, ena, dataout);
  parameter dataa_width = 18;
  parameter output_clock = "none";
  input [dataa_width-1:0] dataa;
  input clk, ena;
  output [dataa_width-1:0] dataout;

  reg [dataa_width-1:0] registered;
  initial registered = 0;
  always @(posedge clk)
    if (ena)
      registered <= dataa;
  assign dataout = output_clock == "none" ? dataa : registered;
endmodule
